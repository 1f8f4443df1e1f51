/*
 * Libraries that print on standard error, kept silent. The descriptor belongs to the process, so
 * there is one lock for all of them: two that redirected it at once would each put back what the
 * other had set.
 */
#include "hush.h"

#include <fcntl.h>
#include <pthread.h>
#include <string.h>
#include <unistd.h>

static pthread_mutex_t one_at_a_time = PTHREAD_MUTEX_INITIALIZER;
static pthread_cond_t nobody_shares = PTHREAD_COND_INITIALIZER;
/* Under the lock: those who want silence and no text, and what they found on the descriptor. */
static int sharing;
static int shared_saved = -1;

void hl_hush_share(void)
{
  pthread_mutex_lock(&one_at_a_time);
  if (sharing++ == 0) {
    const int nothing = open("/dev/null", O_WRONLY | O_CLOEXEC);
    fflush(stderr);
    shared_saved = nothing >= 0 ? fcntl(STDERR_FILENO, F_DUPFD_CLOEXEC, 0) : -1;
    if (shared_saved >= 0)
      dup2(nothing, STDERR_FILENO);
    if (nothing >= 0 && nothing != STDERR_FILENO) /* it is where standard error was closed */
      close(nothing);
  }
  pthread_mutex_unlock(&one_at_a_time);
}

void hl_hush_leave(void)
{
  pthread_mutex_lock(&one_at_a_time);
  if (--sharing == 0) {
    if (shared_saved >= 0) {
      fflush(stderr);
      dup2(shared_saved, STDERR_FILENO);
      close(shared_saved);
    }
    shared_saved = -1;
    pthread_cond_broadcast(&nobody_shares);
  }
  pthread_mutex_unlock(&one_at_a_time);
}

void hl_hush_begin(hl_hush *hush)
{
  pthread_mutex_lock(&one_at_a_time);
  while (sharing > 0)
    pthread_cond_wait(&nobody_shares, &one_at_a_time);
  *hush = (hl_hush){tmpfile(), -1};
  if (!hush->file)
    return;
  fflush(stderr);
  hush->saved = fcntl(STDERR_FILENO, F_DUPFD_CLOEXEC, 0);
  if (hush->saved >= 0)
    dup2(fileno(hush->file), STDERR_FILENO);
}

void hl_hush_end(hl_hush *hush, char *line, size_t room)
{
  if (hush->saved >= 0) {
    fflush(stderr);
    dup2(hush->saved, STDERR_FILENO);
    close(hush->saved);
  }
  if (line) {
    line[0] = '\0';
    if (hush->file) {
      rewind(hush->file);
      if (!fgets(line, (int)room, hush->file))
        line[0] = '\0';
      line[strcspn(line, "\r\n")] = '\0';
    }
  }
  if (hush->file)
    fclose(hush->file);
  *hush = (hl_hush){NULL, -1};
  pthread_mutex_unlock(&one_at_a_time);
}
