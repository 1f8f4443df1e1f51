/* Whether the channels' lobes differ in more than their colour.
 *
 * Every channel c is fitted with a lobe x_c of its own. With the border profiled out, S_c the Schur
 * complement of its normal equations and x_c* its best lobe, one shape x in colours a_c costs
 *
 *   sum_c (a_c x - x_c*)' S_c (a_c x - x_c*)
 *
 * more. It is least by turns: x for given a, a for given x, each a linear problem.
 */
#include <math.h>
#include <string.h>

#include "cholesky.h"
#include "light_work.h"

enum { TURNS = 20, MOST = HL_SPLINE_MAX };
static const double pivot = 1e-12;

typedef struct lobe {
  double s[MOST][MOST]; /* S_c */
  double x[MOST];       /* x_c* */
  double sx[MOST];      /* S_c x_c* */
} lobe;

/* S = A_ll - A_lb A_bb^-1 A_bl, by the factor U'U = A_bb. */
static void profile(const hl_normal *a, const double *best, lobe *out)
{
  double dense[HL_COLUMNS_MAX * HL_COLUMNS_MAX], border[HL_BORDER_MAX][HL_BORDER_MAX] = {{0}};
  double part[MOST][HL_BORDER_MAX];
  const int n = a->n, m = a->m, total = n + m;
  hl_normal_dense(a, dense);
  for (int i = 0; i < m; i++)
    for (int j = 0; j < m; j++)
      border[i][j] = dense[(n + i) * total + n + j];
  (void)hl_cholesky(border[0], m, HL_BORDER_MAX, pivot);
  for (int i = 0; i < n; i++) {
    for (int j = 0; j < m; j++)
      part[i][j] = dense[i * total + n + j];
    hl_cholesky_forward(border[0], m, HL_BORDER_MAX, part[i]);
  }
  for (int i = 0; i < n; i++) {
    out->x[i] = best[i];
    for (int j = 0; j < n; j++) {
      out->s[i][j] = dense[i * total + j];
      for (int k = 0; k < m; k++)
        out->s[i][j] -= part[i][k] * part[j][k];
    }
  }
  for (int i = 0; i < n; i++) {
    out->sx[i] = 0;
    for (int j = 0; j < n; j++)
      out->sx[i] += out->s[i][j] * out->x[j];
  }
}

/* Best shape in given colours. */
static void shape_of(const lobe *of, int channels, int n, const double *colour, double *x)
{
  double sum[MOST][MOST];
  memset(x, 0, MOST * sizeof *x);
  memset(sum, 0, sizeof sum);
  for (int c = 0; c < channels; c++)
    for (int i = 0; i < n; i++) {
      /* NOLINTNEXTLINE(clang-analyzer-core.UndefinedBinaryOperatorResult): profile() fills n */
      x[i] += colour[c] * of[c].sx[i];
      for (int j = 0; j < n; j++)
        sum[i][j] += colour[c] * colour[c] * of[c].s[i][j];
    }
  (void)hl_cholesky(sum[0], n, MOST, pivot);
  hl_cholesky_solve(sum[0], n, MOST, x);
}

/* Best colour of a shape, and what the shape costs with it. */
static double colour_of(const lobe *of, int n, const double *x, double *colour)
{
  double xsx = 0, xs_best = 0, best = 0;
  for (int i = 0; i < n; i++) {
    for (int j = 0; j < n; j++)
      xsx += x[i] * of->s[i][j] * x[j];
    xs_best += x[i] * of->sx[i];
    best += of->x[i] * of->sx[i];
  }
  *colour = xsx > 0 ? xs_best / xsx : 0;
  return fmax(best - *colour * xs_best, 0);
}

double hl_light_one_shape(struct hl_light_work *work, const hl_light_model *model, int threads)
{
  const int channels = work->all.channels, n = model->has_lobe ? model->spline.n : 0;
  hl_normal normal[HL_CHANNELS_MAX];
  lobe of[HL_CHANNELS_MAX];
  double colour[HL_CHANNELS_MAX], x[MOST], more = 0;
  if (channels < 2 || n == 0)
    return 0;
  hl_model_normal(model, &work->all, threads, &work->model, &work->best.at, normal);
  for (int c = 0; c < channels; c++) {
    profile(&normal[c], work->best.at.x[c], &of[c]);
    colour[c] = 1;
  }
  for (int turn = 0; turn < TURNS; turn++) {
    shape_of(of, channels, n, colour, x);
    more = 0;
    for (int c = 0; c < channels; c++)
      more += colour_of(&of[c], n, x, &colour[c]);
  }
  return more;
}
