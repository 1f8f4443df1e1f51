/* Allocations that fail on demand, for the library's own calls and jansson's. The program is linked with
 * --wrap for each (tests/CMakeLists.txt), so that the sanitizers still see what is allocated. */
#ifndef HL_TEST_MEMORY_FAULTS_H
#define HL_TEST_MEMORY_FAULTS_H

#include <errno.h>
#include <jansson.h>
#include <stdio.h>
#include <stdlib.h>

typedef struct faults {
  long count;  /* calls so far */
  long at;     /* the call that fails; 0 = none */
  int onwards; /* and all after it */
  int sparing; /* jansson's calls neither count nor fail */
  long blocks; /* allocated and not freed */
} faults_state;

static faults_state faults;

static int faults_fail(void)
{
  const long call = __atomic_add_fetch(&faults.count, 1, __ATOMIC_RELAXED);
  const int fails = faults.at > 0 && (call == faults.at || (faults.onwards && call > faults.at));
  if (fails)
    errno = ENOMEM;
  return fails;
}

static void *faults_keep(void *block)
{
  if (block)
    __atomic_add_fetch(&faults.blocks, 1, __ATOMIC_RELAXED);
  return block;
}

#define WRAPPED(type, name, parameters, arguments)                                                 \
  type __real_##name parameters;                                                                   \
  type __wrap_##name parameters;                                                                   \
  type __wrap_##name parameters                                                                    \
  {                                                                                                \
    return faults_fail() ? NULL : faults_keep(__real_##name arguments);                            \
  }

WRAPPED(void *, malloc, (size_t n), (n))
WRAPPED(void *, calloc, (size_t n, size_t size), (n, size))
WRAPPED(char *, strdup, (const char *text), (text))
WRAPPED(char *, strndup, (const char *text, size_t n), (text, n))
#undef WRAPPED

void *__real_realloc(void *block, size_t n);
void *__wrap_realloc(void *block, size_t n);
void *__wrap_realloc(void *block, size_t n)
{
  if (faults_fail())
    return NULL;
  void *moved = __real_realloc(block, n);
  return block ? moved : faults_keep(moved);
}

/* These two hand out blocks of their own. */
char *__real_realpath(const char *path, char *out);
char *__wrap_realpath(const char *path, char *out);
char *__wrap_realpath(const char *path, char *out)
{
  if (!out && faults_fail())
    return NULL;
  char *real = __real_realpath(path, out);
  return out ? real : faults_keep(real);
}

ssize_t __real_getline(char **line, size_t *room, FILE *file);
ssize_t __wrap_getline(char **line, size_t *room, FILE *file);
ssize_t __wrap_getline(char **line, size_t *room, FILE *file)
{
  const int empty = !*line;
  const ssize_t n = __real_getline(line, room, file);
  if (empty)
    faults_keep(*line);
  return n;
}

void __real_free(void *block);
void __wrap_free(void *block);
void __wrap_free(void *block)
{
  if (block)
    __atomic_sub_fetch(&faults.blocks, 1, __ATOMIC_RELAXED);
  __real_free(block);
}

static void *faults_jansson(size_t n)
{
  return faults.sparing ? faults_keep(__real_malloc(n)) : __wrap_malloc(n);
}

static inline void faults_begin(void)
{
  json_set_alloc_funcs(faults_jansson, __wrap_free);
}

#endif
