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

void hl_hush_begin(hl_hush *hush)
{
  pthread_mutex_lock(&one_at_a_time);
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
