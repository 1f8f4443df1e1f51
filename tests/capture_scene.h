/* A recorded session of small frames, for tests that play it as a camera. */
#ifndef HL_TEST_CAPTURE_SCENE_H
#define HL_TEST_CAPTURE_SCENE_H

#include <ftw.h>
#include <sys/stat.h>

#include "../calib/capture_work.h"
#include "files.h"

enum { SCENE_WIDTH = 12, SCENE_HEIGHT = 8, SCENE_FRAMES = 6 };
#define SCENE_EXPOSURE 5000.0
#define SCENE_GAIN 2.0

static inline int remove_entry(const char *path, const struct stat *s, int kind, struct FTW *at)
{
  (void)s;
  (void)kind;
  (void)at;
  return remove(path);
}

static inline int tree_free(void **state)
{
  nftw(*state, remove_entry, 8, FTW_DEPTH | FTW_PHYS);
  free(*state);
  return 0;
}

enum { SCENE_PATH_MAX = TEST_PATH_MAX + 128 };

/* folder/name; folders of these tests are short. */
static inline void scene_join(char out[SCENE_PATH_MAX], const char *folder, const char *name)
{
  assert_true(strlen(folder) + strlen(name) + 2 <= SCENE_PATH_MAX);
  stpcpy(stpcpy(stpcpy(out, folder), "/"), name);
}

/* Code of a pixel of frame k; every frame differs. */
static inline uint16_t scene_code(int k, int i)
{
  return (uint16_t)(1000 * k + 37 * i + (i == 5 ? 60000 - 6000 * k : 0));
}

static inline void scene_codes(int k, int width, uint16_t *codes)
{
  for (int i = 0; i < width * SCENE_HEIGHT; i++)
    codes[i] = scene_code(k, i);
}

/* `folder`/session.json with SCENE_FRAMES frames, and these faults. */
static inline void scene_record(const char *folder, const hl_session_fault *faults, int n_faults)
{
  hl_session s;
  uint16_t codes[SCENE_WIDTH * SCENE_HEIGHT];
  char path[SCENE_PATH_MAX];
  assert_int_equal(mkdir(folder, 0777), 0);
  assert_int_equal(hl_session_new(NULL, folder, &s), HL_OK);
  free(s.device);
  s.device = strdup("test camera");
  s.pixels = HL_PIXELS_RAW_GREEN;
  for (int k = 0; k < SCENE_FRAMES; k++) {
    char file[16];
    char label[8];
    snprintf(file, sizeof file, "r%d.%s", k, hl_capture_picture_ending(16));
    snprintf(label, sizeof label, "R%d", k);
    scene_codes(k, SCENE_WIDTH, codes);
    const hl_capture_frame picture = {
        .codes = codes, .width = SCENE_WIDTH, .height = SCENE_HEIGHT, .channels = 1, .bits = 16};
    hl_session_frame f = {.file = file,
                          .label = label,
                          .timestamp_ns = INT64_C(1000000) * (k + 1),
                          .exposure_us = SCENE_EXPOSURE,
                          .gain = SCENE_GAIN,
                          .digital_gain = 1};
    scene_join(path, folder, file);
    assert_int_equal(hl_capture_picture_write(NULL, path, &picture), HL_OK);
    assert_int_equal(hl_file_sha256(NULL, path, f.sha256), HL_OK);
    assert_int_equal(hl_session_append(NULL, &s, &f), HL_OK);
  }
  s.fault = calloc((size_t)n_faults + 1, sizeof *s.fault);
  assert_non_null(s.fault);
  for (int i = 0; i < n_faults; i++)
    s.fault[s.n_faults++] = faults[i];
  assert_int_equal(hl_session_write(NULL, &s), HL_OK);
  hl_session_free(&s);
}

static inline hl_capture_plan scene_plan(const char *out)
{
  return (hl_capture_plan){
      .folder = out,
      .n_frames = SCENE_FRAMES,
      .locked = {.exposure_us = SCENE_EXPOSURE, .gain = SCENE_GAIN, .focus_dioptre = -1}};
}

/* Do the pixels of the session's frame say that it is frame k of the recording? */
static inline void assert_frame_is(const hl_session *s, int at, int k)
{
  hl_frame frame;
  char *path = NULL;
  char sum[65];
  assert_int_equal(hl_session_path(NULL, s, s->frame[at].file, &path), HL_OK);
  assert_int_equal(hl_file_sha256(NULL, path, sum), HL_OK);
  assert_string_equal(sum, s->frame[at].sha256);
  assert_int_equal(hl_frame_read(NULL, path, &s->frame_settings, &frame), HL_OK);
  for (int i = 0; i < SCENE_WIDTH * SCENE_HEIGHT; i++)
    assert_near(frame.radiance[i] * 65535.0, scene_code(k, i), 0.01);
  hl_frame_free(&frame);
  free(path);
}

static const char *const scene_labels[] = {"L0", "L1", "L2", "L3", "L4", "L5"};

/* Play `recording` into `plan`. */
static inline hl_status play(hl_ctx *ctx, const char *recording, const hl_capture_plan *plan,
                             hl_capture_result *result)
{
  hl_capture_source source;
  assert_int_equal(hl_capture_recorded(ctx, recording, true, &source), HL_OK);
  const hl_status st = hl_capture_run(ctx, &source, plan, result);
  source.close(source.state);
  return st;
}

typedef struct place {
  char good[SCENE_PATH_MAX], bad[SCENE_PATH_MAX], out[SCENE_PATH_MAX], json[SCENE_PATH_MAX];
} place;

/* A healthy recording, one with these faults, and where the session goes. */
static inline place make_place(void **state, const char *name, const hl_session_fault *faults,
                               int n)
{
  place p;
  char folder[SCENE_PATH_MAX];
  scene_join(folder, *state, name);
  assert_int_equal(mkdir(folder, 0777), 0);
  scene_join(p.good, folder, "good");
  scene_join(p.bad, folder, "bad");
  scene_join(p.out, folder, "out");
  scene_join(p.json, folder, "out/session.json");
  scene_record(p.good, NULL, 0);
  scene_record(p.bad, faults, n);
  return p;
}

static inline void assert_whole(const char *out, const char *const *names)
{
  hl_session s;
  assert_int_equal(hl_session_read(NULL, out, &s), HL_OK);
  assert_int_equal(s.n, SCENE_FRAMES);
  for (int k = 0; k < s.n; k++) {
    assert_frame_is(&s, k, k);
    assert_string_equal(s.frame[k].label, names ? names[k] : "");
    assert_true(s.frame[k].timestamp_ns == INT64_C(1000000) * (k + 1));
    assert_near(s.frame[k].exposure_us, SCENE_EXPOSURE, 0);
    assert_near(s.frame[k].digital_gain, 1, 0);
    assert_null(s.frame[k].untrusted);
  }
  assert_string_equal(s.device, "test camera");
  assert_int_equal(s.pixels, HL_PIXELS_RAW_GREEN);
  assert_int_equal(s.size_px[0], SCENE_WIDTH);
  assert_int_equal(s.size_px[1], SCENE_HEIGHT);
  assert_near(s.locked.gain, SCENE_GAIN, 0);
  hl_session_free(&s);
}

/* hl_capture_plan.go_on: until two frames are there. */
static inline bool until_two(void *user, int done, int total)
{
  (void)user;
  assert_int_equal(total, SCENE_FRAMES);
  return done < 2;
}

#endif
