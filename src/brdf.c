/* Which BRDF a fitted reflectance stands for.
 *
 * Under light of irradiance E a BRDF rho shows R = E rho(s,v) (n.s). The fitted forms, E = 1:
 *
 *   k (n.s)                   rho = k                      Lambert
 *   f(n.h) M^m / (n.v)        rho = f(n.h) M^m / ((n.s)(n.v))   a microfacet lobe, 4 D F G in f
 *   f(n.h)                    rho = f(n.h) / (n.s)         Phong's, and not reciprocal
 *   f(n.a), a not h or s      not reciprocal either
 *
 * A table of (theta_half, theta_diff, phi_diff) has one cell for (s,v) and (v,s), and one for all turns
 * about n: it holds isotropic reciprocal BRDFs alone. All these forms depend on n.s, n.v and s.v only,
 * so they are isotropic and the same for phi_diff and -phi_diff. With R' = R(n, v, s), the radiance when
 * light and view change places, the reciprocal rho whose radiance comes nearest to both,
 *
 *   min (rho (n.s) - R)^2 + (rho (n.v) - R')^2   is   rho = ((n.s) R + (n.v) R') / ((n.s)^2 + (n.v)^2),
 *
 * which leaves a reciprocal R as it is and stays finite where only one cosine vanishes. On the ball of
 * one frame both ends of the choice are seen: the pixel n and its mirror image in the plane between s
 * and v. What they disagree by is the misfit of the form, since a real surface is reciprocal. */

#include "halflight/brdf.h"
#include "halflight/notes.h"
#include "halflight/vec3.h"
#include <math.h>
#include <string.h>

enum { ALBEDO_RINGS = 2048, BALL = 48 };
static const double pi = 3.14159265358979323846;
static const double horizon = 0.01; /* least cosine that a cell is filled at */

hl_brdf_settings hl_brdf_defaults(void)
{
  const hl_brdf_settings s = {.irradiance = 1, .albedo = 0};
  return s;
}

const hl_field_table *hl_brdf_fields(void)
{
  static const hl_field fields[] = {
      {"irradiance", HL_FIELD_DOUBLE, offsetof(hl_brdf_settings, irradiance), 1e-12, 1e12, "",
       "the light's, at normal incidence, in the frame's units", NULL},
      {"albedo", HL_FIELD_DOUBLE, offsetof(hl_brdf_settings, albedo), 0, 1, "",
       "of the brightest channel, light along the normal; 0 goes by the irradiance", NULL},
  };
  static const hl_field_table table = {"BRDF settings", fields,
                                       (int)(sizeof fields / sizeof *fields)};
  return &table;
}

void hl_brdf_at(const hl_reflectance *reflectance, const double n[3], const double s[3],
                const double v[3], double out[3])
{
  const double ns = hl_dot(n, s), nv = hl_dot(n, v);
  double there[HL_CHANNELS_MAX], back[HL_CHANNELS_MAX];
  hl_reflectance_at(reflectance, n, s, v, there);
  hl_reflectance_at(reflectance, n, v, s, back);
  for (int c = 0; c < 3; c++)
    out[c] = ns > 0 && nv > 0 ? (ns * there[c] + nv * back[c]) / (ns * ns + nv * nv) : 0;
}

/* Raise a direction to the horizon. */
static void lift(double d[3])
{
  if (d[2] >= horizon)
    return;
  const double flat = hypot(d[0], d[1]), wide = sqrt(1 - horizon * horizon);
  d[0] = flat > 0 ? d[0] * wide / flat : wide;
  d[1] = flat > 0 ? d[1] * wide / flat : 0;
  d[2] = horizon;
}

/* Both halves of a row of phi_diff at once. Returns how many values below 0 were made 0. */
static long fill(const hl_reflectance *reflectance, hl_merl *merl)
{
  static const double n[3] = {0, 0, 1};
  long negative = 0;
  for (int i = 0; i < HL_MERL_THETA_HALF; i++)
    for (int j = 0; j < HL_MERL_THETA_DIFF; j++)
      for (int k = 0; k < HL_MERL_PHI_DIFF / 2; k++) {
        double s[3], v[3], value[3];
        hl_merl_directions(hl_merl_center(i, j, k), s, v);
        lift(s);
        lift(v);
        hl_brdf_at(reflectance, n, s, v, value);
        for (int c = 0; c < 3; c++) {
          double *at = merl->value + (size_t)c * HL_MERL_CELLS;
          const double stored = fmax(value[c], 0) / hl_merl_scale(c);
          negative += value[c] < 0;
          at[hl_merl_cell(i, j, k)] = at[hl_merl_cell(i, j, HL_MERL_PHI_DIFF - 1 - k)] = stored;
        }
      }
  return negative;
}

/* 2 pi int rho cos sin dtheta for light along the normal; rings are narrow where the highlight is. */
static void albedo_of(const hl_reflectance *reflectance, double albedo[3])
{
  static const double n[3] = {0, 0, 1};
  memset(albedo, 0, 3 * sizeof *albedo);
  for (int i = 0; i < ALBEDO_RINGS; i++) {
    const double u = (i + 0.5) / ALBEDO_RINGS, theta = u * u * pi / 2;
    const double width = pi * u / ALBEDO_RINGS;
    const double v[3] = {sin(theta), 0, cos(theta)};
    double rho[3];
    hl_brdf_at(reflectance, n, n, v, rho);
    for (int c = 0; c < 3; c++)
      albedo[c] += 2 * pi * fmax(rho[c], 0) * v[0] * v[2] * width;
  }
}

/* How far the BRDF's radiance is from the fit's own on a ball under the fit's light and view. */
static double asymmetry_of(const hl_reflectance *reflectance)
{
  const double *s = reflectance->light, *v = reflectance->view;
  double a[3], b[3], difference = 0, sum = 0;
  hl_tangent_basis(v, a, b);
  for (int i = 0; i < BALL * BALL; i++) {
    const int row = i / BALL, column = i % BALL;
    const double x = (column + 0.5) * 2 / BALL - 1, y = (row + 0.5) * 2 / BALL - 1;
    const double under = 1 - x * x - y * y;
    double n[3], fitted[HL_CHANNELS_MAX], rho[3];
    if (!(under > 0))
      continue;
    for (int k = 0; k < 3; k++)
      n[k] = x * a[k] + y * b[k] + sqrt(under) * v[k];
    hl_reflectance_at(reflectance, n, s, v, fitted);
    hl_brdf_at(reflectance, n, s, v, rho);
    for (int c = 0; c < 3; c++) {
      difference += fabs(rho[c] * hl_dot(n, s) - fitted[c]);
      sum += fabs(fitted[c]);
    }
  }
  return sum > 0 ? difference / sum : 0;
}

static hl_status check(hl_ctx *ctx, const hl_reflectance *r, const hl_brdf_settings *settings)
{
  const hl_status st = hl_fields_check(ctx, hl_brdf_fields(), settings);
  if (st != HL_OK)
    return st;
  for (int i = 0; i < r->n_terms; i++)
    if (r->term[i].fixed_axis)
      return hl_fail(
          ctx, HL_ERR_DEGENERATE,
          "the axis of '%s' is not known in terms of light and view, so no BRDF follows; "
          "a fit that knows its light is needed",
          r->term[i].name);
  return HL_OK;
}

static void note(const hl_reflectance *r, long negative, hl_brdf_summary *summary)
{
  summary->notes = r->notes;
  summary->asymmetry = r->has_light ? asymmetry_of(r) : (double)NAN;
  if (summary->asymmetry > 1e-6)
    hl_notes_add(
        &summary->notes, "not reciprocal",
        "the table holds the nearest reciprocal BRDF, %.2g %% from the fit under its light",
        100 * summary->asymmetry);
  if (negative > 0)
    hl_notes_add(&summary->notes, "below 0", "%ld values were made 0: a table takes no others",
                 negative);
  if (fmax(summary->albedo[0], fmax(summary->albedo[1], summary->albedo[2])) > 1)
    hl_notes_add(&summary->notes, "albedo above 1",
                 "more than the light that came; a larger irradiance, or an albedo, is needed");
}

hl_status hl_brdf_table(hl_ctx *ctx, const hl_reflectance *reflectance,
                        const hl_brdf_settings *settings, hl_merl *merl, hl_brdf_summary *summary)
{
  const hl_brdf_settings own = settings ? *settings : hl_brdf_defaults();
  hl_brdf_summary made = {.irradiance = own.irradiance};
  hl_merl table;
  hl_status st = check(ctx, reflectance, &own);
  if (st != HL_OK)
    return st;
  albedo_of(reflectance, made.albedo);
  const double most = fmax(made.albedo[0], fmax(made.albedo[1], made.albedo[2]));
  if (own.albedo > 0 && !(most > 0 && isfinite(most)))
    return hl_fail(ctx, HL_ERR_ARG,
                   "albedo = %g for a reflectance whose own is %g; one that reflects is needed",
                   own.albedo, most);
  if (own.albedo > 0)
    made.irradiance = most / own.albedo;
  st = hl_merl_new(ctx, &table);
  if (st != HL_OK)
    return st;
  const long negative = fill(reflectance, &table);
  for (size_t i = 0; i < 3 * (size_t)HL_MERL_CELLS; i++)
    table.value[i] /= made.irradiance;
  for (int c = 0; c < 3; c++)
    made.albedo[c] /= made.irradiance;
  note(reflectance, negative, &made);
  *merl = table;
  if (summary)
    *summary = made;
  return HL_OK;
}
