/**
 * Corners of a target seen in a number of views: detected in frames, or read from a `.vnl`.
 */
#ifndef HALFLIGHT_CORNERS_H
#define HALFLIGHT_CORNERS_H

#include <stdbool.h>

#include "halflight/frame.h"
#include "halflight/target.h"

#ifdef __cplusplus
extern "C" {
#endif

enum { HL_VIEW_NAME_MAX = 256, HL_REASON_MAX = 160, HL_VIEWS_MAX = 1 << 20 };

/** One corner in one view. */
typedef struct hl_corner {
  double x, y;  /* pixels; (0,0) is the centre of the top-left pixel */
  double sigma; /* relative standard deviation, 1 for most; 0 = not seen */
} hl_corner;

/** One view; `corner` belongs to the set. */
typedef struct hl_view {
  char name[HL_VIEW_NAME_MAX]; /* the frame's file, as it was given */
  hl_corner *corner;           /* shape (hl_target_corners(target)) in board order */
  int seen;                    /* corners with sigma > 0 */
  bool used;                   /* false: left out before the calibration, `why` says */
  char why[HL_REASON_MAX];
} hl_view;

/** Owner of its arrays; `hl_corners_free` releases them. */
typedef struct hl_corners {
  hl_target target;
  int width, height; /* of every frame; 0 = not known yet */
  int n_views, room;
  hl_view *view;
} hl_corners;

/** Begin an empty set. */
HL_API hl_corners hl_corners_of(const hl_target *target);
/** Release what it holds; the target stays. NULL is accepted. */
HL_API void hl_corners_free(hl_corners *corners);

/**
 * Append a view in which nothing is seen yet and that is used; *out is borrowed from the set until
 * the next append. Who fills it counts `seen`.
 * @return HL_OK; HL_ERR_ARG (no name, or one of HL_VIEW_NAME_MAX bytes or more); HL_ERR_MEMORY,
 *         also beyond HL_VIEWS_MAX views
 */
HL_API hl_status hl_corners_add(hl_ctx *ctx, hl_corners *corners, const char *name, hl_view **out);

/**
 * Read mrcal's `.vnl`: `# filename x y [level]`, a row a corner in board order, `-` where unseen, a
 * level below 0 as unseen, otherwise sigma = 2^level. Width and height stay 0.
 * @return HL_OK; HL_ERR_IO; HL_ERR_FORMAT (a line that is no row; a view with another number of
 *         rows than the target has corners, saying both; no views); HL_ERR_MEMORY
 */
HL_API hl_status hl_corners_read(hl_ctx *ctx, const char *path, const hl_target *target,
                                 hl_corners *out);

/** Write mrcal's `.vnl`, whole or not at all. */
HL_API hl_status hl_corners_write(hl_ctx *ctx, const char *path, const hl_corners *corners);

/** What the detector saw, for messages. */
typedef struct hl_detection {
  int tags;        /* tags of the target's family */
  int border_bits; /* 1 or 2; 0 for a chessboard or where no tag was seen */
  int foreign;     /* tags whose id the target does not have; they are not used */
  double blur_px;  /* standard deviation of the edges at the corners, median over the view; where no
                      board was found, of the frame's strongest edges, 0 for none */
  bool top_left_ids; /* ids begin at the top left instead of Kalibr's bottom left */
} hl_detection;

/**
 * Find the target in one frame and append the view (also one without a corner: `used` false and
 * `why`). AprilGrids need AprilTag, chessboards OpenCV; AprilGrids with black squares at the tags'
 * corners, as Kalibr's and our own, are ten times as accurate with OpenCV as without. A chessboard
 * must be seen whole; an AprilGrid may be seen in part, from two tags on. Its border may be one bit
 * or two, its ids may begin at the bottom left or the top left, and its tags may be printed turned.
 *
 * Corners are measured on linear radiance, the mean of the channels, and kept in whole millionths of
 * a pixel, so that a `.vnl` holds them exactly. Their sigma is 1, but 8 for tags that only a coded
 * copy of the frame showed and that stand alone. calib/saddle.c, calib/aprilgrid.c and
 * calib/chessboard.c say how accurate they are, and how a chessboard's first corner is chosen.
 *
 * A view is left out, with its reason, where no board or too little of it is found (and then what
 * was), where the board is another one than the target, is seen mirrored (of chessboards only those
 * with two different odd sides can tell), is blurred so that its corners say little, or fits no
 * plane seen by a camera.
 *
 * While AprilTag runs, standard error of the whole process is held back, as hl_frame_read does it.
 *
 * @param detection may be NULL
 * @return HL_OK; HL_ERR_ARG (name); HL_ERR_FORMAT (the frame's size differs from that of the views
 *         before, or is over 32767 pixels a side for an AprilGrid); HL_ERR_UNAVAILABLE (the library
 *         it needs is not in this build); HL_ERR_MEMORY. Nothing is appended but on HL_OK
 *
 * Cost O(pixels): a frame of 640 x 480 takes 0.1 s, one of 12 megapixels 1 to 6. The same frame gives
 * the same corners, bit for bit, on any number of threads.
 */
HL_API hl_status hl_corners_detect(hl_ctx *ctx, hl_corners *corners, const hl_frame *frame,
                                   const char *name, hl_detection *detection);

#ifdef __cplusplus
}
#endif
#endif
