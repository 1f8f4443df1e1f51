/* How bright each light is, seen through the one reflectance that all frames share.
 *
 * A light's curves are the ball's times its radiance: log y_ik = log a_i + log m_k + e_ik at knot k (the
 * body, and the lobe at a few angles). Knots differ in how well frames agree on them: a sharp peak and a
 * faint tail do not. With S_kl the variance of log y_k - log y_l over the frames, which the light's own
 * brightness leaves, that of knot k alone is (S_kl + S_km - S_lm) / 2 (Grubbs 1948), the median over all
 * l, m. The weighted mean over the knots is where each light starts.
 *
 * How firmly a frame holds its curve differs more. Under a light near the view, body and lobe are nearly one
 * curve, and how the frame divides between them is chance; the covariance C of that is known from the frame's
 * normal equations (hl_light_pose_profile). With the session's curve m fixed, generalized least squares under
 * C + diag(var) gives such a light the brightness that its frame does know. A frame that knows its curve has
 * small C, and nothing changes.
 *
 * Stated deviation: body and lobe are two readings of one brightness; of the lobe's knot that agrees best with
 * the body (of two knots apart, where there is no body: neighbours on one curve err together), S is the variance
 * of their difference, so that of their mean is S / 4; what C adds is added.
 *
 * A frame whose curves are not the session's, though its ball is, has taken body for lobe or the other
 * way round, and its direction with it: it is not to be trusted.
 */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "cholesky.h"
#include "halflight/notes.h"
#include "replay_work.h"

static const double knot_rad[HL_REPLAY_KNOTS] = {0,     0.0524, 0.105, 0.175,
                                                 0.262, 0.349,  0.524}; /* [0]: the body */
static const double least_scatter = 1e-3, least_share = 1e-3;
/* Knots that are shown by a tenth of the largest and on which frames agree to 5 % must agree to this. */
static const double telling_share = 0.1, telling_scatter = 0.05, agreement = 0.25;

static const double misfit_accepted = 22.46; /* chi^2, 6 degrees of freedom, 0.999 */

enum { LEAST_FRAMES = 4, ROUNDS = 6, TELL_ROUNDS = 4 };

static double at_angle(const hl_curve *curve, double angle)
{
  for (int i = 1; i < curve->n; i++)
    if (curve->angle_rad[i] >= angle) {
      const double width = curve->angle_rad[i] - curve->angle_rad[i - 1];
      const double t = width > 0 ? (angle - curve->angle_rad[i - 1]) / width : 0;
      return curve->value[i - 1] + t * (curve->value[i] - curve->value[i - 1]);
    }
  return 0;
}

void hl_replay_profile(const hl_light *light, double profile[3][HL_REPLAY_KNOTS])
{
  int c = 0;
  memset(profile, 0, 3 * sizeof *profile);
  for (int i = 0; i < light->channels; i++)
    profile[i][0] = fmax(light->diffuse_strength[i], 0);
  for (int i = 0; i < light->n_curves; i++) {
    if (strcmp(light->curves[i].lobe, "specular") != 0)
      continue;
    for (int k = 1; k < HL_REPLAY_KNOTS; k++)
      profile[c][k] = at_angle(&light->curves[i], knot_rad[k]);
    c++;
  }
  for (int i = light->channels; i < 3; i++)
    memcpy(profile[i], profile[0], sizeof profile[0]);
}

void hl_replay_open(const hl_light *light, const hl_light_work *work,
                    const hl_light_pose_work *pose, double open[3][HL_REPLAY_PAIRS])
{
  double covariance[HL_REPLAY_KNOTS * HL_REPLAY_KNOTS];
  for (int c = 0; c < 3; c++) {
    int at = 0;
    if (c >= light->channels) {
      memcpy(open[c], open[0], sizeof open[c]);
      continue;
    }
    hl_light_pose_profile(work, pose, c, light->mean_cos_view, knot_rad, HL_REPLAY_KNOTS,
                          covariance);
    for (int k = 0; k < HL_REPLAY_KNOTS; k++)
      for (int l = k; l < HL_REPLAY_KNOTS; l++)
        open[c][at++] = covariance[k * HL_REPLAY_KNOTS + l];
  }
}

static int compare(const void *a, const void *b)
{
  const double x = *(const double *)a, y = *(const double *)b;
  return (x > y) - (x < y);
}

typedef struct channel {
  int n;
  double (*y)[HL_REPLAY_KNOTS]; /* log, NAN where it is not shown */
  double *a;                    /* log */
  double *room;
  const double **open; /* shape (n): as hl_replay_seen's, of this channel */
  double *exposure;
  double m[HL_REPLAY_KNOTS], variance[HL_REPLAY_KNOTS];
  double stated; /* variance of `a`; HUGE_VAL: not known */
} channel;

static double median_in(double *values, int n)
{
  qsort(values, (size_t)n, sizeof *values, compare);
  return 0.5 * (values[(n - 1) / 2] + values[n / 2]);
}

/* Robust variance of y_k - y_l; NAN where too few frames show both. */
static double variance_between(channel *ch, int k, int l)
{
  int n = 0;
  for (int i = 0; i < ch->n; i++)
    if (isfinite(ch->y[i][k]) && isfinite(ch->y[i][l]))
      ch->room[n++] = ch->y[i][k] - ch->y[i][l];
  if (n < LEAST_FRAMES || 2 * n < ch->n)
    return NAN;
  const double middle = median_in(ch->room, n);
  for (int i = 0; i < n; i++)
    ch->room[i] = fabs(ch->room[i] - middle);
  const double sigma = 1.4826 * median_in(ch->room, n);
  return sigma * sigma;
}

static void variances(channel *ch)
{
  double s[HL_REPLAY_KNOTS][HL_REPLAY_KNOTS], found[HL_REPLAY_KNOTS * HL_REPLAY_KNOTS];
  for (int k = 0; k < HL_REPLAY_KNOTS; k++)
    for (int l = 0; l < k; l++)
      s[k][l] = s[l][k] = variance_between(ch, k, l);
  ch->stated = HUGE_VAL;
  for (int l = 1; l < HL_REPLAY_KNOTS; l++)
    ch->stated = isfinite(s[0][l]) ? fmin(ch->stated, s[0][l]) : ch->stated;
  for (int k = 1; k < HL_REPLAY_KNOTS && !isfinite(ch->stated); k++)
    for (int l = k + 2; l < HL_REPLAY_KNOTS; l++)
      ch->stated = isfinite(s[k][l]) ? fmin(ch->stated, s[k][l]) : ch->stated;
  for (int k = 0; k < HL_REPLAY_KNOTS; k++) {
    int n = 0;
    for (int l = 0; l < HL_REPLAY_KNOTS; l++)
      for (int m = 0; m < l; m++)
        if (l != k && m != k && isfinite(s[k][l] + s[k][m] + s[l][m]))
          found[n++] = 0.5 * (s[k][l] + s[k][m] - s[l][m]);
    ch->variance[k] = n > 0 ? fmax(median_in(found, n), least_scatter * least_scatter) : HUGE_VAL;
  }
}

/* The median of each knot over the frames, their brightness taken off. */
static void medians(channel *ch)
{
  for (int k = 0; k < HL_REPLAY_KNOTS; k++) {
    int n = 0;
    for (int i = 0; i < ch->n; i++)
      if (isfinite(ch->y[i][k]) && isfinite(ch->a[i]))
        ch->room[n++] = ch->y[i][k] - ch->a[i];
    ch->m[k] = n > 0 ? median_in(ch->room, n) : 0;
  }
}

static void scales(channel *ch)
{
  for (int i = 0; i < ch->n; i++) {
    double sum = 0, weight = 0;
    for (int k = 0; k < HL_REPLAY_KNOTS; k++)
      if (isfinite(ch->y[i][k]) && isfinite(ch->variance[k])) {
        sum += (ch->y[i][k] - ch->m[k]) / ch->variance[k];
        weight += 1 / ch->variance[k];
      }
    if (weight > 0)
      ch->a[i] = sum / weight;
  }
}

static void gather(const hl_replay_run *run, const hl_lights *lights, int c, channel *ch)
{
  for (int i = 0; i < ch->n; i++) {
    const hl_rig_light *l = &lights->light[i];
    const double *p = run->frame[i].seen[l->ball].profile[c];
    double most = 0;
    for (int k = 0; k < HL_REPLAY_KNOTS; k++)
      most = fmax(most, p[k]);
    ch->a[i] = l->found && most > 0 ? 0 : NAN;
    ch->open[i] = run->frame[i].seen[l->ball].open[c];
    const double exposure = (l->exposure_us > 0 ? l->exposure_us : 1) * (l->gain > 0 ? l->gain : 1);
    ch->exposure[i] = exposure;
    for (int k = 0; k < HL_REPLAY_KNOTS; k++)
      ch->y[i][k] = l->found && p[k] > least_share * most ? log(p[k] / exposure) : NAN;
  }
}

static double median_of(channel *ch)
{
  int n = 0;
  for (int i = 0; i < ch->n; i++)
    if (isfinite(ch->a[i]))
      ch->room[n++] = ch->a[i];
  return n > 0 ? median_in(ch->room, n) : 0;
}

/* Where frames agree on nothing the body is what there is, else the lobe. */
static void fall_back(channel *ch)
{
  for (int k = 0; k < HL_REPLAY_KNOTS; k++)
    if (isfinite(ch->variance[k]))
      return;
  for (int k = 0; k < HL_REPLAY_KNOTS; k++) {
    int n = 0;
    for (int i = 0; i < ch->n; i++)
      n += isfinite(ch->y[i][k]);
    if (n > 0 && 2 * n >= ch->n) {
      ch->variance[k] = 1;
      return;
    }
  }
}

/* What a frame says about its light's brightness once the session's curve is known. */
typedef struct told {
  double a;      /* log */
  double excess; /* beyond that of a frame whose pixels tell everything apart */
  double misfit; /* of its curve from the session's, in deviations squared */
} told;

/* Generalized least squares of exp(a) m to the frame's curve z about the present a: with z and its open
 * part C both in units of exp(a) m,
 *
 *   a += (1' V^-1 (z - 1)) / (1' V^-1 1),   V = C + diag(variance). */
static bool tell(const channel *ch, int i, told *out)
{
  double v[HL_REPLAY_KNOTS * HL_REPLAY_KNOTS], z[HL_REPLAY_KNOTS], one[HL_REPLAY_KNOTS];
  double unit[HL_REPLAY_KNOTS], plain = 0;
  int at[HL_REPLAY_KNOTS], n = 0;
  for (int k = 0; k < HL_REPLAY_KNOTS; k++)
    if (isfinite(ch->y[i][k]) && isfinite(ch->variance[k]))
      at[n++] = k;
  for (int p = 0; p < n; p++) {
    unit[p] = ch->exposure[i] * exp(out->a + ch->m[at[p]]);
    z[p] = exp(ch->y[i][at[p]] - out->a - ch->m[at[p]]) - 1;
    one[p] = 1;
    plain += 1 / ch->variance[at[p]];
  }
  for (int p = 0; p < n; p++)
    for (int q = p; q < n; q++) {
      const int k = at[p], l = at[q];
      const int pair = k * HL_REPLAY_KNOTS - k * (k - 1) / 2 + l - k;
      v[p * n + q] = v[q * n + p] =
          ch->open[i][pair] / (unit[p] * unit[q]) + (p == q ? ch->variance[k] : 0);
    }
  if (n == 0 || hl_cholesky(v, n, n, 1e-12) > 0)
    return false;
  double w[HL_REPLAY_KNOTS], sum = 0, weight = 0, misfit = 0;
  memcpy(w, one, sizeof w);
  hl_cholesky_solve(v, n, n, w);
  for (int p = 0; p < n; p++) {
    sum += w[p] * z[p];
    weight += w[p];
  }
  const double step = sum / weight;
  for (int p = 0; p < n; p++)
    one[p] = z[p] - step;
  memcpy(w, one, sizeof w);
  hl_cholesky_solve(v, n, n, w);
  for (int p = 0; p < n; p++)
    misfit += w[p] * one[p];
  if (!isfinite(step) || !(step > -0.9))
    return false;
  *out = (told){out->a + log1p(step), fmax(0, 1 / weight - 1 / plain), misfit};
  return true;
}

static bool agrees(const channel *ch, int i)
{
  double most = -HUGE_VAL;
  for (int k = 0; k < HL_REPLAY_KNOTS; k++)
    most = isfinite(ch->variance[k]) ? fmax(most, ch->m[k]) : most;
  for (int k = 0; k < HL_REPLAY_KNOTS; k++) {
    const double sigma = sqrt(ch->variance[k]);
    if (!(sigma <= telling_scatter) || ch->m[k] < most + log(telling_share))
      continue;
    if (!(fabs(ch->y[i][k] - ch->a[i] - ch->m[k]) <= agreement))
      return false;
  }
  return true;
}

static void solve(const hl_replay_run *run, int c, channel *ch, hl_lights *out)
{
  double least = HUGE_VAL;
  gather(run, out, c, ch);
  variances(ch);
  fall_back(ch);
  for (int k = 0; k < HL_REPLAY_KNOTS; k++)
    least = fmin(least, ch->variance[k]);
  for (int k = 0; k < HL_REPLAY_KNOTS; k++) /* a start from one of the best knots alone */
    if (!(ch->variance[k] > least))
      for (int i = 0; i < ch->n; i++)
        ch->a[i] = isfinite(ch->a[i]) && isfinite(ch->y[i][k]) ? ch->y[i][k] : ch->a[i];
  for (int round = 0; round < ROUNDS; round++) {
    medians(ch);
    scales(ch);
  }
  medians(ch);
  const double middle = median_of(ch);
  for (int i = 0; i < ch->n; i++) {
    hl_rig_light *l = &out->light[i];
    if (!l->found || !isfinite(ch->a[i]))
      continue;
    told t = {.a = ch->a[i]};
    bool open = ch->n >= LEAST_FRAMES;
    for (int round = 0; round < TELL_ROUNDS && open; round++)
      open = tell(ch, i, &t);
    l->intensity[c] = exp((open ? t.a : ch->a[i]) - middle);
    if (isfinite(ch->stated)) {
      const double variance = open ? ch->stated / 4 + t.excess : ch->stated;
      l->intensity_sigma = fmax(l->intensity_sigma, fmax(sqrt(variance), least_scatter));
    }
    if (l->trusted && ch->n >= LEAST_FRAMES && !agrees(ch, i) &&
        !(open && t.misfit <= misfit_accepted)) {
      l->trusted = false;
      (void)hl_note_list_add(&l->reasons, "reflectance",
                             "body and lobe are not those of the session's other frames");
    }
  }
}

hl_status hl_replay_intensity(hl_ctx *ctx, const hl_replay_run *run, hl_lights *out)
{
  const size_t n = (size_t)out->n;
  channel ch = {.n = out->n,
                .y = malloc(n * sizeof *ch.y),
                .a = malloc(n * sizeof *ch.a),
                .room = malloc(n * sizeof *ch.room),
                .open = malloc(n * sizeof *ch.open),
                .exposure = malloc(n * sizeof *ch.exposure)};
  const bool good = ch.y && ch.a && ch.room && ch.open && ch.exposure;
  for (int c = 0; c < 3 && good; c++)
    solve(run, c, &ch, out);
  free(ch.y);
  free(ch.a);
  free(ch.room);
  free(ch.open);
  free(ch.exposure);
  return good ? HL_OK : hl_fail(ctx, HL_ERR_MEMORY, "no memory for %d intensities", out->n);
}
