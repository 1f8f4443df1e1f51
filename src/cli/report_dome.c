/* The drawing, orthographic, from a point TURN degrees right of the camera and TILT above it. Space is
 * that of .lp files: x right, y up, z to the camera. page.js turns the same points by the same formula;
 * each shape carries them. */
#include "report_dome.h"

#include <math.h>

enum { RING_POINTS = 48, ELLIPSE_POINTS = 24 };

static const double PI = 3.14159265358979323846;
static const double TURN = 24, TILT = 20; /* degrees */
static const double SIZE = 150;           /* units of the drawing a unit of space */
static const double CHI_95 = 2.4477468306808162;
static const double LEAST_SEEN = 0.085; /* half axis of an ellipse that can be seen, in space */

static void seen(const double p[3], double at[3])
{
  const double a = TURN * PI / 180, b = TILT * PI / 180;
  const double x = cos(a) * p[0] + sin(a) * p[2], z = -sin(a) * p[0] + cos(a) * p[2];
  at[0] = SIZE * x;
  at[1] = -SIZE * (cos(b) * p[1] - sin(b) * z);
  at[2] = sin(b) * p[1] + cos(b) * z;
}

static void put_point(hl_page *page, const double p[3], bool first)
{
  fprintf(page->out, "%s%.3f,%.3f,%.3f", first ? "" : " ", p[0], p[1], p[2]);
}

static void put_line(hl_page *page, const char *style, double (*points)[3], int n)
{
  fprintf(page->out, "<polyline class=\"%s\" data-p=\"", style);
  for (int i = 0; i < n; i++)
    put_point(page, points[i], i == 0);
  fputs("\" points=\"", page->out);
  for (int i = 0; i < n; i++) {
    double at[3];
    seen(points[i], at);
    fprintf(page->out, "%s%.1f,%.1f", i ? " " : "", at[0], at[1]);
  }
  fputs("\"/>\n", page->out);
}

/* Circles at 30 and 60 degrees from the camera's axis, the limb at 90, and four half circles over. */
static void put_grid(hl_page *page)
{
  double points[RING_POINTS + 1][3];
  for (int ring = 1; ring <= 3; ring++) {
    const double from_axis = ring * PI / 6;
    for (int i = 0; i <= RING_POINTS; i++) {
      const double a = 2 * PI * i / RING_POINTS;
      points[i][0] = sin(from_axis) * cos(a);
      points[i][1] = sin(from_axis) * sin(a);
      points[i][2] = cos(from_axis);
    }
    put_line(page, ring == 3 ? "rim" : "line", points, RING_POINTS + 1);
  }
  for (int k = 0; k < 4; k++) {
    for (int i = 0; i <= RING_POINTS; i++) {
      const double a = PI * i / RING_POINTS;
      points[i][0] = cos(a) * cos(k * PI / 4);
      points[i][1] = cos(a) * sin(k * PI / 4);
      points[i][2] = sin(a);
    }
    put_line(page, "line", points, RING_POINTS + 1);
  }
}

static void put_axis(hl_page *page, double x, double y, double z, const char *name)
{
  double line[2][3] = {{0, 0, 0}, {1.12 * x, 1.12 * y, 1.12 * z}};
  const double end[3] = {1.2 * x, 1.2 * y, 1.2 * z};
  double at[3];
  put_line(page, "axis", line, 2);
  seen(end, at);
  fputs("<text text-anchor=\"middle\" data-p=\"", page->out);
  put_point(page, end, true);
  fprintf(page->out, "\" x=\"%.1f\" y=\"%.1f\">%s</text>\n", at[0], at[1], name);
}

static void to_lp(const double camera[3], double lp[3])
{
  lp[0] = camera[0];
  lp[1] = -camera[1];
  lp[2] = -camera[2];
}

/* Half axis of the largest ellipse, in space. */
static double largest_axis(const hl_dome_light *lights, int n)
{
  double most = 0;
  for (int i = 0; i < n; i++) {
    const double(*c)[2] = lights[i].covariance_rad2;
    const double half = 0.5 * (c[0][0] + c[1][1]);
    const double root = hypot(0.5 * (c[0][0] - c[1][1]), c[0][1]);
    most = fmax(most, CHI_95 * sqrt(fmax(half + root, 0)));
  }
  return most;
}

/* 1, 2 or 5 times a power of ten so that the largest ellipse shows; 0 where there is none to show. */
static int choose_factor(double axis)
{
  int factor = 1;
  if (!(axis > 0) || !isfinite(axis))
    return 0;
  for (int i = 0; i < 15 && factor * axis < LEAST_SEEN; i++)
    factor = i % 3 == 1 ? factor / 2 * 5 : factor * 2;
  return factor * axis < LEAST_SEEN ? 0 : factor;
}

static void put_ellipse(hl_page *page, const hl_dome_light *light, int factor)
{
  const double(*c)[2] = light->covariance_rad2;
  const double l00 = sqrt(fmax(c[0][0], 0)), l10 = l00 > 0 ? c[1][0] / l00 : 0;
  const double l11 = sqrt(fmax(c[1][1] - l10 * l10, 0));
  double points[ELLIPSE_POINTS + 1][3];
  for (int i = 0; i <= ELLIPSE_POINTS; i++) {
    const double t = 2 * PI * i / ELLIPSE_POINTS;
    const double a = factor * CHI_95 * l00 * cos(t);
    const double b = factor * CHI_95 * (l10 * cos(t) + l11 * sin(t));
    double p[3];
    for (int k = 0; k < 3; k++)
      p[k] = light->direction[k] + a * light->basis[0][k] + b * light->basis[1][k];
    to_lp(p, points[i]);
  }
  put_line(page, light->trusted ? "ellipse" : "ellipse doubt", points, ELLIPSE_POINTS + 1);
}

static void put_light(hl_page *page, const hl_dome_light *light, double radius)
{
  double p[3], at[3];
  to_lp(light->direction, p);
  seen(p, at);
  fprintf(page->out, "<circle class=\"light%s%s\" r=\"%.1f\" cx=\"%.1f\" cy=\"%.1f\" data-p=\"",
          light->trusted ? "" : " doubt", at[2] < 0 ? " behind" : "", radius, at[0], at[1]);
  put_point(page, p, true);
  fputs("\"><title>", page->out);
  hl_page_text(page, light->label);
  hl_page_printf(page, "%s", light->trusted ? "" : ", not to be trusted");
  fputs("</title></circle>\n", page->out);
}

static void put_caption(hl_page *page, int n, int n_doubt, int factor)
{
  fputs("<figcaption><b>", page->out);
  hl_page_printf(page, "%s on the hemisphere.", n == 1 ? "The light" : "The lights");
  fputs("</b> ", page->out);
  hl_page_printf(page, "Circles every 30 degrees about the camera's axis. %s",
                 n_doubt == 0   ? ""
                 : n_doubt == n ? "Vermillion and dashed: not to be trusted. "
                                : "Blue: to be trusted; vermillion and dashed: not. ");
  if (factor > 1)
    hl_page_printf(page, "95 %% ellipses are drawn %d times enlarged. ", factor);
  else if (factor == 1)
    hl_page_printf(page, "Ellipses hold the light with a probability of 95 %%. ");
  fputs("<span class=\"turn\">Drag the drawing, or use the arrow keys, to turn it.</span>"
        "</figcaption></figure>\n",
        page->out);
}

void hl_page_dome(hl_page *page, const hl_dome_light *lights, int n)
{
  const int factor = choose_factor(largest_axis(lights, n));
  const double radius = n == 1 ? 4 : n < 40 ? 3.5 : 2.6;
  int n_doubt = 0;
  for (int i = 0; i < n; i++)
    n_doubt += !lights[i].trusted;
  fputs("<figure><div class=\"turn\"><button type=\"button\" data-view=\"0,0\">From the "
        "camera</button>"
        "<button type=\"button\" data-view=\"0,90\">From above</button>"
        "<button type=\"button\" data-view=\"90,0\">From the side</button>"
        "<button type=\"button\" data-view=\"\">As at first</button></div>\n",
        page->out);
  fprintf(page->out,
          "<svg class=\"dome\" role=\"img\" tabindex=\"0\" width=\"420\" height=\"380\" "
          "viewBox=\"-210 -190 420 380\" data-size=\"%.0f\" data-turn=\"%.0f,%.0f\" "
          "aria-label=\"",
          SIZE, TURN, TILT);
  hl_page_printf(
      page,
      "%d light%s on a hemisphere around the camera's axis, of which %d not to be trusted; "
      "the table has the directions.",
      n, n == 1 ? "" : "s", n_doubt);
  fputs("\">\n", page->out);
  put_grid(page);
  put_axis(page, 1, 0, 0, "right");
  put_axis(page, 0, 1, 0, "up");
  put_axis(page, 0, 0, 1, "camera");
  for (int i = 0; i < n && factor > 0; i++)
    put_ellipse(page, lights + i, factor);
  for (int i = 0; i < n; i++)
    put_light(page, lights + i, radius);
  fputs("</svg>\n", page->out);
  put_caption(page, n, n_doubt, factor);
}

static bool read_rows(const json_t *rows, int n, int m, double *out)
{
  for (int i = 0; i < n; i++)
    for (int k = 0; k < m; k++) {
      const json_t *value = json_array_get(json_array_get(rows, (size_t)i), (size_t)k);
      out[i * m + k] = json_is_number(value) ? json_number_value(value) : 0;
    }
  return json_is_array(rows);
}

bool hl_dome_light_read(const json_t *light, const char *label, bool trusted, hl_dome_light *out)
{
  double length = 0;
  hl_json_doubles(light, "direction", 3, out->direction);
  for (int k = 0; k < 3; k++)
    length += out->direction[k] * out->direction[k];
  if (!(fabs(length - 1) < 1e-3))
    return false;
  read_rows(json_object_get(light, "tangent_basis"), 2, 3, out->basis[0]);
  read_rows(json_object_get(light, "covariance_rad2"), 2, 2, out->covariance_rad2[0]);
  out->label = label;
  out->trusted = trusted;
  return true;
}
