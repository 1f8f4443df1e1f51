/* Radiance less its linear part a.n is one ridge function f(b.n) of R's ppr, for the paper's equation
 *
 *   rho(n) = a.n + f(b.n)                                         (4)
 *
 * and the light is the mean view mirrored about b. The pixels are those of Lambert's rule: lit, not
 * clipped. Data and answers go through files that have no name, so that nothing is left whatever happens.
 */
#include "bench_ppr.h"

#include <math.h>
#include <spawn.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/wait.h>

#include "halflight/vec3.h"

enum { SCENES_MAX = 256 };
static const double least_lit = 0.02; /* of the brightest pixel */

extern char **environ;

/* Reads count, then rows of normal and radiance, until there are no more; prints seconds and b. */
static const char script[] =
    "con <- file('stdin', 'rb')\n"
    "repeat {\n"
    "  n <- readBin(con, 'integer', 1, size = 4)\n"
    "  if (length(n) == 0) break\n"
    "  d <- matrix(readBin(con, 'double', 4 * n, size = 8), ncol = 4, byrow = TRUE)\n"
    "  x <- d[, 1:3]\n"
    "  b <- c(0, 0, 0)\n"
    "  t <- system.time(try(b <- ppr(x, lm.fit(x, d[, 4])$residuals, nterms = 1)$alpha,\n"
    "                       silent = TRUE))\n"
    "  cat(t[['user.self']] + t[['sys.self']], b, '\\n')\n"
    "}\n";

struct hl_ppr {
  FILE *data;
  int n;
  bool full; /* a scene found no room, and would count as one without an answer */
  double view[SCENES_MAX][3], truth[SCENES_MAX][3];
};

hl_ppr *hl_ppr_new(void)
{
  hl_ppr *p = calloc(1, sizeof *p);
  if (!p)
    return NULL;
  p->data = tmpfile();
  if (!p->data) {
    free(p);
    return NULL;
  }
  return p;
}

void hl_ppr_free(hl_ppr *p)
{
  if (!p)
    return;
  fclose(p->data);
  free(p);
}

static bool counts(const hl_bench_scene *s, int pixel, float least)
{
  for (int c = 0; c < s->frame.channels; c++)
    if (s->frame.state[pixel * s->frame.channels + c] != HL_SAMPLE_OK)
      return false;
  return s->grey[pixel] > least;
}

void hl_ppr_add(hl_ppr *p, const hl_bench_scene *s)
{
  float most = 0;
  int32_t n = 0;
  if (!p)
    return;
  p->full = p->n == SCENES_MAX;
  if (p->full)
    return;
  for (int i = 0; i < s->surface.n; i++)
    most = fmaxf(most, s->grey[s->surface.pixel[i]]);
  const float least = (float)least_lit * most;
  for (int i = 0; i < s->surface.n; i++)
    n += counts(s, s->surface.pixel[i], least);
  fwrite(&n, sizeof n, 1, p->data);
  for (int i = 0; i < s->surface.n; i++) {
    const int pixel = s->surface.pixel[i];
    const double value = (double)s->grey[pixel];
    if (!counts(s, pixel, least))
      continue;
    fwrite(s->surface.normal + 3 * i, sizeof value, 3, p->data);
    fwrite(&value, sizeof value, 1, p->data);
    hl_add_scaled(p->view[p->n], 1, s->surface.view + 3 * i, p->view[p->n]);
  }
  memcpy(p->truth[p->n], s->light, sizeof s->light);
  p->n++;
}

/* Whether Rscript ran on `in` and ended well. */
static bool run_r(FILE *in, FILE *out)
{
  char program[] = "Rscript", vanilla[] = "--vanilla", expression[] = "-e";
  char text[sizeof script];
  char *argv[] = {program, vanilla, expression, text, NULL};
  posix_spawn_file_actions_t actions;
  pid_t child;
  int status = 0;
  memcpy(text, script, sizeof script);
  if (posix_spawn_file_actions_init(&actions) != 0)
    return false;
  posix_spawn_file_actions_adddup2(&actions, fileno(in), 0);
  posix_spawn_file_actions_adddup2(&actions, fileno(out), 1);
  posix_spawn_file_actions_addopen(&actions, 2, "/dev/null", 1 /* O_WRONLY */, 0);
  const bool started = posix_spawnp(&child, program, &actions, NULL, argv, environ) == 0;
  posix_spawn_file_actions_destroy(&actions);
  return started && waitpid(child, &status, 0) == child && WIFEXITED(status) &&
         WEXITSTATUS(status) == 0;
}

/* One line of four: seconds and b. */
static bool read_numbers(FILE *in, double number[4])
{
  char line[256], *at = line;
  if (!fgets(line, sizeof line, in))
    return false;
  for (int i = 0; i < 4; i++) {
    char *end;
    number[i] = strtod(at, &end);
    if (end == at || !isfinite(number[i]))
      return false;
    at = end;
  }
  return true;
}

bool hl_ppr_run(hl_ppr *p, hl_ppr_answer *answers)
{
  FILE *out = p && !p->full && fflush(p->data) == 0 && !ferror(p->data) ? tmpfile() : NULL;
  if (!out)
    return false;
  rewind(p->data);
  bool good = run_r(p->data, out);
  rewind(out);
  for (int i = 0; good && i < p->n; i++) {
    double number[4], *b = number + 1, v[3];
    hl_ppr_answer *a = answers + i;
    good = read_numbers(out, number);
    if (!good)
      break;
    hl_unit(p->view[i], v);
    a->time_ms = 1e3 * number[0];
    a->found = hl_norm(b) > 0;
    memcpy(a->truth, p->truth[i], sizeof a->truth);
    hl_unit(b, b);
    for (int k = 0; k < 3; k++)
      a->light[k] = 2 * hl_dot(b, v) * b[k] - v[k]; /* the same for -b */
  }
  fclose(out);
  return good;
}
