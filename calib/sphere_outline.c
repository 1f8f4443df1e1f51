/*
 * Where a ball's outline lies, to a few hundredths of a pixel.
 *
 * The rim is read in sectors. In each the offset of the outline is found by Gauss-Newton on the
 * profile of sphere_rim.c, whose linear part is projected out (Kaufman's form of variable
 * projection). Rays within a sector come from a second-order expansion about its middle.
 */
#include "sphere_outline.h"

#include <string.h>

#include "halflight/vec3.h"
#include "sphere_rim.h"

static const double profile_trust = 0.02;

/* Second-order expansion of the ray about a pixel: one lens inversion a node, not a pixel. */
typedef struct ray_map {
  double x, y;
  double c[6][3]; /* 1, dx, dy, dx^2, dx dy, dy^2 */
} ray_map;

static bool ray_map_set(const hl_camera *camera, double x, double y, ray_map *map)
{
  const double h = 4;
  double r[9][3];
  for (int i = 0; i < 9; i++) {
    const int right = i % 3 - 1, down = i / 3 - 1;
    if (hl_camera_unproject(NULL, camera, x + h * right, y + h * down, r[i]) != HL_OK)
      return false;
  }
  map->x = x;
  map->y = y;
  for (int k = 0; k < 3; k++) {
    map->c[0][k] = r[4][k];
    map->c[1][k] = (r[5][k] - r[3][k]) / (2 * h);
    map->c[2][k] = (r[7][k] - r[1][k]) / (2 * h);
    map->c[3][k] = (r[5][k] - 2 * r[4][k] + r[3][k]) / (2 * h * h);
    map->c[4][k] = (r[8][k] - r[6][k] - r[2][k] + r[0][k]) / (4 * h * h);
    map->c[5][k] = (r[7][k] - 2 * r[4][k] + r[1][k]) / (2 * h * h);
  }
  return true;
}

/* Ray at a pixel and its derivatives by x and y. */
static void ray_map_at(const ray_map *map, double x, double y, double u[3], double ux[3],
                       double uy[3])
{
  const double dx = x - map->x, dy = y - map->y;
  for (int k = 0; k < 3; k++) {
    const double cx = map->c[1][k], cy = map->c[2][k];
    const double cxx = map->c[3][k], cxy = map->c[4][k], cyy = map->c[5][k];
    u[k] = map->c[0][k] + dx * (cx + cxx * dx + cxy * dy) + dy * (cy + cyy * dy);
    ux[k] = cx + 2 * cxx * dx + cxy * dy;
    uy[k] = cy + 2 * cyy * dy + cxy * dx;
  }
}

/* Depth inside the outline [px] and its gradient (unit normal, inward) at one pixel. */
static double depth_at(const ray_map *map, const hl_cone *cone, double x, double y, double g[2],
                       double *rad_per_px)
{
  double u[3], ux[3], uy[3], across[3];
  ray_map_at(map, x, y, u, ux, uy);
  const double p = hl_dot(u, cone->e1), q = hl_dot(u, cone->e2), z = hl_dot(u, cone->axis);
  const double rho = sqrt(p * p + q * q), length = sqrt(rho * rho + z * z);
  const double phi = atan2(rho, z);
  for (int k = 0; k < 3; k++)
    across[k] = ((p * cone->e1[k] + q * cone->e2[k]) * (z / rho) - rho * cone->axis[k]) / length;
  const double gx = -hl_dot(across, ux), gy = -hl_dot(across, uy);
  const double scale = sqrt(gx * gx + gy * gy);
  g[0] = gx / scale;
  g[1] = gy / scale;
  *rad_per_px = scale;
  return (cone->half_angle_rad - phi) / scale;
}

/* Mean of the channels; false where one is clipped or unusable: such a pixel moves the edge. */
static bool pixel_value(const hl_frame *frame, int x, int y, double *out)
{
  const size_t ch = (size_t)frame->channels;
  const size_t at = ((size_t)y * (size_t)frame->width + (size_t)x) * ch;
  double sum = 0;
  for (size_t c = at; c < at + ch; c++) {
    if (frame->state[c] != HL_SAMPLE_OK)
      return false;
    sum += (double)frame->radiance[c];
  }
  *out = sum / (double)ch;
  return true;
}

/* Pixels of one sector; false where too few of the expected ones can be used. */
static bool gather(const hl_frame *frame, const ray_map *map, const hl_cone *cone,
                   const double middle[2], double half_width, double reach, hl_rim_pixels *out)
{
  const double box = hypot(half_width, reach) + 1;
  const int x0 = (int)ceil(middle[0] - box), x1 = (int)floor(middle[0] + box);
  const int y0 = (int)ceil(middle[1] - box), y1 = (int)floor(middle[1] + box);
  double g0[2], g[2], scale;
  depth_at(map, cone, middle[0], middle[1], g0, &scale);
  int expected = 0, n = 0;
  for (int y = y0; y <= y1; y++) {
    for (int x = x0; x <= x1; x++) {
      const double s = (y - middle[1]) * g0[0] - (x - middle[0]) * g0[1];
      if (!(fabs(s) <= half_width))
        continue;
      const double t = depth_at(map, cone, x, y, g, &scale);
      if (!(fabs(t) <= reach))
        continue;
      expected++;
      if (x < 0 || y < 0 || x >= frame->width || y >= frame->height || n == HL_RIM_PIXELS_MAX)
        continue;
      double v;
      if (!pixel_value(frame, x, y, &v))
        continue;
      out->t[n] = t;
      out->s[n] = s / half_width;
      out->gx2[n] = g[0] * g[0];
      out->gy2[n] = g[1] * g[1];
      out->value[n++] = v;
    }
  }
  double mean = 0;
  for (int i = 0; i < n; i++)
    mean += out->value[i] / n;
  for (int i = 0; i < n; i++) /* so that sums of squares lose no digits */
    out->value[i] -= mean;
  out->n = n;
  return n >= 4 * HL_RIM_TERMS && 4 * n >= 3 * expected;
}

/* The best of a few offsets: the residual has more than one valley when the start is far off. */
static void scan(const hl_rim_pixels *px, double reach, hl_rim_fit *best)
{
  static const double at[4] = {-1.3, -0.6, 0.6, 1.3};
  for (int i = 0; i < 4; i++) {
    hl_rim_fit other;
    hl_rim_solve(px, at[i], reach, &other);
    if (other.ssr < best->ssr)
      *best = other;
  }
}

/* Takes one step down; false where there is none. */
static bool descend(const hl_rim_pixels *px, double reach, double step, hl_rim_fit *f)
{
  if (!(fabs(step) < 0.7))
    step = copysign(0.7, step);
  for (int cut = 0; cut < 4; cut++) {
    hl_rim_fit next;
    hl_rim_solve(px, f->offset + step, reach, &next);
    if (next.ssr < f->ssr) {
      *f = next;
      return true;
    }
    step *= 0.4;
  }
  return false;
}

static void read_sector(const hl_rim_pixels *px, double reach, bool wide, hl_outline_sector *out)
{
  hl_rim_fit f;
  double information, pull;
  hl_rim_solve(px, 0, reach, &f);
  if (wide)
    scan(px, reach, &f);
  hl_rim_slope(px, &f, reach, &information, &pull);
  for (int it = 0; it < 6; it++) {
    const double step = pull / information;
    /* a step far below its own error changes nothing */
    const double sigma = sqrt(fmax(f.ssr, 0) / (px->n - HL_RIM_TERMS - 1) / information);
    if (!(fabs(step) > fmax(1e-4, 0.02 * sigma)) || !descend(px, reach, step, &f))
      break;
    hl_rim_slope(px, &f, reach, &information, &pull);
    if (!(fabs(f.offset) < 0.5 * reach))
      break;
  }
  const double *c = f.c;
  const double variance = fmax(f.ssr, 0) / (px->n - HL_RIM_TERMS - 1);
  const double at_edge = c[3] + 0.5 * c[5] + 0.25 * c[7] / reach;
  const double at_reach = c[3] + sqrt(reach) * c[5] + c[7];
  /* a ball's profile that is not quite of our form moves the edge by its misfit over the step */
  const double profile = profile_trust * (at_reach - at_edge) / (at_edge - c[0]);
  out->offset_px = f.offset;
  out->sigma_px = hypot(sqrt(variance / information), profile);
  /* the error of the step itself is about that of a mean of n / HL_RIM_TERMS pixels */
  const bool seen = fabs(at_edge - c[0]) > 6 * sqrt(variance * HL_RIM_TERMS / px->n);
  if (!seen || !(out->sigma_px < 0.3))
    out->kind = HL_OUTLINE_NO_EDGE;
  else
    out->kind = fabs(f.offset) < 0.5 * reach ? HL_OUTLINE_EDGE : HL_OUTLINE_ASTRAY;
}

/* Two boxes of variance a^2 / 12 and b^2 / 12: the pixel's own, and half of the blur's for each. */
static void set_blur(hl_rim_pixels *px, double blur)
{
  for (int i = 0; i < px->n; i++) {
    px->a[i] = sqrt(fmax(px->gx2[i], 0.0025) + 6 * blur * blur);
    px->b[i] = sqrt(fmax(px->gy2[i], 0.0025) + 6 * blur * blur);
  }
}

/* Gathers the pixels of sector i of n; false where it cannot be read. */
static bool open_sector(const hl_frame *frame, const hl_camera *camera, const hl_cone *cone, int i,
                        int n, double reach, hl_outline_sector *o, hl_rim_pixels *px)
{
  const double round = 6.28318530717958647692, az = round * i / n;
  double ray[3], middle[2], g[2];
  const double st = sin(cone->half_angle_rad), ct = cos(cone->half_angle_rad);
  const double ca = cos(az), sa = sin(az);
  ray_map map;
  memset(o, 0, sizeof *o);
  o->kind = HL_OUTLINE_OUTSIDE;
  o->azimuth_rad = az;
  for (int k = 0; k < 3; k++)
    ray[k] = ct * cone->axis[k] + st * (ca * cone->e1[k] + sa * cone->e2[k]);
  if (hl_camera_project(NULL, camera, ray, middle) != HL_OK)
    return false;
  if (!(middle[0] > -1 && middle[0] < frame->width && middle[1] > -1 && middle[1] < frame->height))
    return false;
  if (!ray_map_set(camera, middle[0], middle[1], &map))
    return false;
  depth_at(&map, cone, middle[0], middle[1], g, &o->rad_per_px);
  const double arc = round * st / (n * o->rad_per_px);
  const double half_width = fmin(7, fmax(0.5 * arc, 4));
  return gather(frame, &map, cone, middle, half_width, reach, px);
}

void hl_outline_read(const hl_frame *frame, const hl_camera *camera, const hl_cone *cone, int n,
                     const hl_outline_look *look, hl_outline_sector *out)
{
  hl_rim_pixels px;
  for (int i = 0; i < n; i++) {
    if (!open_sector(frame, camera, cone, i, n, look->reach_px, &out[i], &px))
      continue;
    set_blur(&px, look->blur_px);
    read_sector(&px, look->reach_px, look->wide, &out[i]);
  }
}

/* Log-likelihood of one sector up to a constant; 0 where there is no edge to judge blur by. */
static double likelihood(const hl_rim_pixels *px, const hl_outline_look *look)
{
  hl_rim_fit f;
  hl_rim_solve(px, 0, look->reach_px, &f);
  if (look->wide)
    scan(px, look->reach_px, &f);
  double squares = 0;
  for (int i = 0; i < px->n; i++)
    squares += px->value[i] * px->value[i];
  const double left = fmax(f.ssr, 0) / (squares + 1e-300);
  return -0.5 * px->n * log(left + 1e-6);
}

double hl_outline_blur(const hl_frame *frame, const hl_camera *camera, const hl_cone *cone, int n,
                       const hl_outline_look *look, const double *blurs, int n_blurs)
{
  double sum[HL_OUTLINE_BLURS_MAX] = {0};
  hl_rim_pixels px;
  hl_outline_sector sector;
  for (int i = 0; i < n; i++) {
    if (!open_sector(frame, camera, cone, i, n, look->reach_px, &sector, &px))
      continue;
    for (int k = 0; k < n_blurs; k++) {
      set_blur(&px, blurs[k]);
      sum[k] += likelihood(&px, look);
    }
  }
  int best = 0;
  for (int k = 1; k < n_blurs; k++)
    if (sum[k] > sum[best])
      best = k;
  if (best == 0 || best == n_blurs - 1)
    return blurs[best];
  /* vertex of the parabola through the best and its neighbours */
  const double x0 = blurs[best - 1] - blurs[best], x1 = blurs[best + 1] - blurs[best];
  const double y0 = sum[best - 1] - sum[best], y1 = sum[best + 1] - sum[best];
  const double bend = y0 * x1 - y1 * x0;
  return bend != 0 ? blurs[best] + 0.5 * (y0 * x1 * x1 - y1 * x0 * x0) / bend : blurs[best];
}
