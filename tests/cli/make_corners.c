/* Corners for the command's tests: an AprilGrid 6 x 6 before a pinhole camera of 640 x 480. It shares
 * nothing with the library: plain C, its own mathematics.
 *
 *   make_corners [member=value ...]      writes corners.vnl here
 *
 * views=N, tilt=RAD (each component of a board's rotation, at most), distance=M (the farthest; the
 * nearest is 0.55 of it), noise=PX, mirror=yes (rows
 * counted backwards), bad=N (so many corners of the first view off by 40 px), spoilt=PX (noise of
 * the second view instead).
 */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { SIDE = 12, WIDTH = 640, HEIGHT = 480 };

static const double TAG = 0.03, GAP = 0.3;
static const double FX = 700, FY = 702, CX = 322.3, CY = 236.8;
static const double K1 = -0.18, K2 = 0.06, P1 = 0.0008, P2 = -0.0005;

typedef struct options {
  int views, bad, mirror;
  double tilt, distance, noise, spoilt;
} options;

static uint64_t random_state = 88172645463325252u;

static double uniform(double low, double high)
{
  random_state ^= random_state << 13;
  random_state ^= random_state >> 7;
  random_state ^= random_state << 17;
  return low + (high - low) * ((double)(random_state >> 11) / 9007199254740992.0);
}

static double normal(void)
{
  const double u = 1 - uniform(0, 1);
  return sqrt(-2 * log(u)) * cos(6.283185307179586 * uniform(0, 1));
}

static double along(int i)
{
  return TAG * (i / 2 * (1 + GAP) + i % 2);
}

/* Rodrigues: p turned about w. */
static void turn(const double w[3], const double p[3], double out[3])
{
  const double angle = sqrt(w[0] * w[0] + w[1] * w[1] + w[2] * w[2]);
  const double s = angle > 0 ? sin(angle) / angle : 1;
  const double c = angle > 0 ? (1 - cos(angle)) / (angle * angle) : 0.5;
  const double dot = w[0] * p[0] + w[1] * p[1] + w[2] * p[2];
  for (int i = 0; i < 3; i++) {
    const int j = (i + 1) % 3, k = (i + 2) % 3;
    out[i] = p[i] * cos(angle) + s * (w[j] * p[k] - w[k] * p[j]) + c * dot * w[i];
  }
}

static void project(const double at[3], double pixel[2])
{
  const double x = at[0] / at[2], y = at[1] / at[2];
  const double q = x * x + y * y, g = 1 + q * (K1 + q * K2);
  pixel[0] = FX * (x * g + 2 * P1 * x * y + P2 * (q + 2 * x * x)) + CX;
  pixel[1] = FY * (y * g + P1 * (q + 2 * y * y) + 2 * P2 * x * y) + CY;
}

/* A view with at least 0.6 of its corners in the frame; NAN for the others. */
static void see(const options *o, double noise, double pixel[SIDE * SIDE][2])
{
  int inside = 0;
  while (inside < 0.6 * SIDE * SIDE) {
    double w[3], t[3];
    for (int i = 0; i < 3; i++)
      w[i] = uniform(-o->tilt, o->tilt);
    t[0] = uniform(-0.29, 0.29) * o->distance;
    t[1] = uniform(-0.22, 0.22) * o->distance;
    t[2] = uniform(0.55, 1) * o->distance;
    inside = 0;
    for (int i = 0; i < SIDE * SIDE; i++) {
      const double middle = along(SIDE - 1) / 2;
      const double board[3] = {along(i % SIDE) - middle, along(i / SIDE) - middle, 0};
      double at[3];
      turn(w, board, at);
      for (int k = 0; k < 3; k++)
        at[k] += t[k];
      project(at, pixel[i]);
      for (int k = 0; k < 2; k++)
        pixel[i][k] += noise * normal();
      if (pixel[i][0] > 0 && pixel[i][0] < WIDTH - 1 && pixel[i][1] > 0 && pixel[i][1] < HEIGHT - 1)
        inside++;
      else
        pixel[i][0] = NAN;
    }
  }
}

static void write_view(FILE *out, const options *o, int view, double pixel[SIDE * SIDE][2])
{
  int bad = view == 0 ? o->bad : 0;
  for (int i = 0; i < SIDE * SIDE; i++) {
    const int from = o->mirror ? i / SIDE * SIDE + SIDE - 1 - i % SIDE : i;
    if (isnan(pixel[from][0])) {
      fprintf(out, "view%02d.png - - -\n", view);
      continue;
    }
    fprintf(out, "view%02d.png %.6f %.6f 0\n", view, pixel[from][0],
            pixel[from][1] + (bad-- > 0 ? 40 : 0));
  }
}

static int set_option(options *o, const char *word)
{
  const char *text = strchr(word, '=');
  const size_t length = text ? (size_t)(text - word) : 0;
  const struct {
    const char *name;
    double *number;
    int *whole;
  } members[] = {
      {"views", NULL, &o->views},       {"bad", NULL, &o->bad},     {"tilt", &o->tilt, NULL},
      {"distance", &o->distance, NULL}, {"noise", &o->noise, NULL}, {"spoilt", &o->spoilt, NULL},
  };
  if (text && strncmp(word, "mirror", length) == 0) {
    o->mirror = strcmp(text, "=yes") == 0;
    return 0;
  }
  for (size_t i = 0; text && i < sizeof members / sizeof *members; i++)
    if (strlen(members[i].name) == length && strncmp(word, members[i].name, length) == 0) {
      if (members[i].number)
        *members[i].number = strtod(text + 1, NULL);
      else
        *members[i].whole = (int)strtol(text + 1, NULL, 10);
      return 0;
    }
  fprintf(stderr, "make_corners: '%s' is no member=value\n", word);
  return 1;
}

int main(int argc, char **argv)
{
  options o = {.views = 12, .tilt = 0.55, .distance = 0.55, .noise = 0.1};
  for (int i = 1; i < argc; i++)
    if (set_option(&o, argv[i]) != 0)
      return 1;
  FILE *out = fopen("corners.vnl", "w");
  if (!out)
    return 1;
  fputs("# filename x y level\n", out);
  for (int view = 0; view < o.views; view++) {
    double pixel[SIDE * SIDE][2];
    see(&o, view == 1 && o.spoilt > 0 ? o.spoilt : o.noise, pixel);
    write_view(out, &o, view, pixel);
  }
  return fclose(out) == 0 ? 0 : 1;
}
