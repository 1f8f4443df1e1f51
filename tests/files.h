/* Files for tests: a folder of their own, thrown away at the end. */
#ifndef HL_TEST_FILES_H
#define HL_TEST_FILES_H

#include <dirent.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include "near.h"

enum { TEST_PATH_MAX = 512 };

/* cmocka group fixtures: *state is the folder's name. */
static inline int folder_new(void **state)
{
  char *name = strdup("/tmp/halflight-test-XXXXXX");
  *state = name;
  return name && mkdtemp(name) ? 0 : -1;
}

static inline int folder_free(void **state)
{
  char *name = *state;
  DIR *folder = opendir(name);
  char path[TEST_PATH_MAX];
  for (struct dirent *e; folder && (e = readdir(folder));) {
    snprintf(path, sizeof path, "%s/%.200s", name, e->d_name);
    if (strcmp(e->d_name, ".") != 0 && strcmp(e->d_name, "..") != 0)
      unlink(path);
  }
  if (folder)
    closedir(folder);
  rmdir(name);
  free(name);
  return 0;
}

/* How many files the folder holds. */
static inline int folder_count(const char *name)
{
  int n = 0;
  DIR *folder = opendir(name);
  assert_non_null(folder);
  while (readdir(folder))
    n++;
  closedir(folder);
  return n - 2;
}

static inline void path_in(void **state, const char *name, char path[TEST_PATH_MAX])
{
  snprintf(path, TEST_PATH_MAX, "%s/%s", (const char *)*state, name);
}

static inline void put_file(const char *path, const void *bytes, size_t n)
{
  FILE *file = fopen(path, "wb");
  assert_non_null(file);
  assert_int_equal(fwrite(bytes, 1, n, file), n);
  assert_int_equal(fclose(file), 0);
}

static inline void put_text(const char *path, const char *text)
{
  put_file(path, text, strlen(text));
}

/* The whole file, with a zero byte after it; free(). */
static inline char *get_file(const char *path, size_t *n)
{
  FILE *file = fopen(path, "rb");
  assert_non_null(file);
  char *bytes = malloc(1 << 22);
  assert_non_null(bytes);
  *n = fread(bytes, 1, (1 << 22) - 1, file);
  bytes[*n] = '\0';
  fclose(file);
  return bytes;
}

/* The message holds this part, is one line, and ends without a full stop. */
static inline void assert_says(const char *msg, const char *part)
{
  if (!strstr(msg, part)) {
    print_error("message '%s' does not say '%s'\n", msg, part);
    fail();
  }
  assert_null(strchr(msg, '\n'));
  assert_true(strlen(msg) > 0 && msg[strlen(msg) - 1] != '.');
}

#endif
