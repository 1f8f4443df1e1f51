/* Inputs for the command's tests: a ball of a simple material under one light, its camera and its
 * pose. It shares nothing with the library: plain C, its own mathematics.
 *
 *   make_ball [member=value ...]      writes camera.json, sphere.json, normals.pfm and a frame here
 *
 * frame=NAME (frame.pfm, or .png: 16 bits, or .8.png: 8 bits sRGB), light=x,y,z, gloss (Blinn's
 * exponent), diffuse, specular, background, gain (times the radiance), channels=1|3,
 * fill=ball|black|constant|clipped|nan|inf (the whole frame or, for nan and inf, the ball),
 * spots=N (so many not-a-number pixels on the ball).
 */
#include <math.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { WIDTH = 160, HEIGHT = 120, OVERSAMPLE = 4 };

static const double FOCAL = 400, CX = 79.5, CY = 59.5;
static const double RADIUS_M = 0.02;
static const double CENTER_M[3] = {0.0025, -0.001, 0.18};

typedef struct options {
  const char *frame, *fill;
  double light[3], gloss, diffuse, specular, background, gain;
  int channels, spots;
} options;

static double dot(const double a[3], const double b[3])
{
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

static void unit(double a[3])
{
  const double n = sqrt(dot(a, a));
  for (int i = 0; i < 3; i++)
    a[i] /= n;
}

/* Nearest hit of the ray through a pixel; 0 where it misses. */
static int hit(double x, double y, double n[3], double v[3])
{
  double ray[3] = {(x - CX) / FOCAL, (y - CY) / FOCAL, 1};
  unit(ray);
  const double along = dot(ray, CENTER_M);
  const double left = along * along - dot(CENTER_M, CENTER_M) + RADIUS_M * RADIUS_M;
  if (left <= 0)
    return 0;
  const double t = along - sqrt(left);
  for (int i = 0; i < 3; i++) {
    n[i] = (t * ray[i] - CENTER_M[i]) / RADIUS_M;
    v[i] = -ray[i];
  }
  return 1;
}

static double radiance(const options *o, const double n[3], const double v[3], int channel)
{
  static const double body[3] = {0.9, 0.5, 0.25};
  const double cosine = dot(n, o->light);
  double h[3];
  if (cosine <= 0)
    return 0;
  for (int i = 0; i < 3; i++)
    h[i] = o->light[i] + v[i];
  unit(h);
  return o->diffuse * body[channel] * cosine + o->specular * pow(fmax(dot(n, h), 0), o->gloss);
}

static float pixel(const options *o, int x, int y, int channel)
{
  double sum = 0;
  int inside = 0;
  for (int i = 0; i < OVERSAMPLE * OVERSAMPLE; i++) {
    double n[3], v[3];
    const double dx = (i % OVERSAMPLE + 0.5) / OVERSAMPLE - 0.5;
    const double dy = (i / OVERSAMPLE + 0.5) / OVERSAMPLE - 0.5;
    const int on = hit(x + dx, y + dy, n, v);
    inside += on;
    sum += on ? radiance(o, n, v, channel) : o->background;
  }
  if (strcmp(o->fill, "black") == 0)
    return 0;
  if (strcmp(o->fill, "constant") == 0)
    return 0.25f;
  if (strcmp(o->fill, "clipped") == 0)
    return 1;
  if (inside && strcmp(o->fill, "nan") == 0)
    return NAN;
  if (inside && strcmp(o->fill, "inf") == 0)
    return INFINITY;
  return (float)(o->gain * sum / (OVERSAMPLE * OVERSAMPLE));
}

static void fail(const char *what)
{
  fprintf(stderr, "make_ball: %s\n", what);
  exit(2);
}

static FILE *open_file(const char *name)
{
  FILE *f = fopen(name, "wb");
  if (!f)
    fail(name);
  return f;
}

/* PFM's rows run from the bottom; this machine is taken to be little-endian. */
static void write_pfm(const char *name, const float *data, int channels)
{
  FILE *f = open_file(name);
  fprintf(f, "%s\n%d %d\n-1.0\n", channels == 3 ? "PF" : "Pf", WIDTH, HEIGHT);
  for (int y = HEIGHT - 1; y >= 0; y--)
    fwrite(data + (size_t)(y * WIDTH * channels), sizeof *data, (size_t)(WIDTH * channels), f);
  fclose(f);
}

static uint32_t crc(uint32_t c, const unsigned char *p, size_t n)
{
  c = ~c;
  for (size_t i = 0; i < n; i++) {
    c ^= p[i];
    for (int k = 0; k < 8; k++)
      c = c & 1 ? 0xedb88320u ^ (c >> 1) : c >> 1;
  }
  return ~c;
}

static void big_endian(unsigned char *at, uint32_t value)
{
  for (int i = 0; i < 4; i++)
    at[i] = (unsigned char)(value >> (24 - 8 * i));
}

static void chunk(FILE *f, const char *kind, const unsigned char *data, size_t n)
{
  unsigned char head[8], tail[4];
  big_endian(head, (uint32_t)n);
  memcpy(head + 4, kind, 4);
  big_endian(tail, crc(crc(0, head + 4, 4), data, n));
  fwrite(head, 1, 8, f);
  fwrite(data, 1, n, f);
  fwrite(tail, 1, 4, f);
}

/* zlib stream of stored blocks, one a row. */
static size_t deflate_stored(const unsigned char *raw, size_t row, unsigned char *out)
{
  uint32_t a = 1, b = 0;
  size_t n = 0;
  out[n++] = 0x78;
  out[n++] = 0x01;
  for (int y = 0; y < HEIGHT; y++, raw += row) {
    out[n++] = y == HEIGHT - 1;
    out[n++] = (unsigned char)(row & 255);
    out[n++] = (unsigned char)(row >> 8);
    out[n++] = (unsigned char)(~row & 255);
    out[n++] = (unsigned char)((~row >> 8) & 255);
    memcpy(out + n, raw, row);
    n += row;
    for (size_t i = 0; i < row; i++) {
      a = (a + raw[i]) % 65521;
      b = (b + a) % 65521;
    }
  }
  big_endian(out + n, b << 16 | a);
  return n + 4;
}

static void write_png(const char *name, const float *data, int channels, int bytes)
{
  const size_t row = 1 + (size_t)(WIDTH * channels * bytes);
  unsigned char *raw = calloc(HEIGHT, row);
  unsigned char *packed = malloc(HEIGHT * (row + 5) + 16);
  unsigned char header[13] = {0};
  if (!raw || !packed)
    fail("no memory");
  for (int i = 0; i < WIDTH * HEIGHT * channels; i++) {
    double v = fmin(fmax(data[i], 0), 1);
    if (bytes == 1)
      v = v <= 0.0031308 ? 12.92 * v : 1.055 * pow(v, 1 / 2.4) - 0.055;
    const unsigned code = (unsigned)(v * (bytes == 2 ? 65535 : 255) + 0.5);
    unsigned char *at =
        raw + (size_t)(i / (WIDTH * channels)) * row + 1 + (size_t)(i % (WIDTH * channels) * bytes);
    if (bytes == 2)
      *at++ = (unsigned char)(code >> 8);
    *at = (unsigned char)(code & 255);
  }
  big_endian(header, WIDTH);
  big_endian(header + 4, HEIGHT);
  header[8] = (unsigned char)(8 * bytes);
  header[9] = channels == 3 ? 2 : 0;
  FILE *f = open_file(name);
  fwrite("\211PNG\r\n\032\n", 1, 8, f);
  chunk(f, "IHDR", header, sizeof header);
  chunk(f, "IDAT", packed, deflate_stored(raw, row, packed));
  chunk(f, "IEND", packed, 0);
  fclose(f);
  free(raw);
  free(packed);
}

static void write_geometry(void)
{
  FILE *f = open_file("camera.json");
  fprintf(f,
          "{\"format\": \"halflight-camera\", \"version\": 1, \"model\": \"pinhole\",\n"
          " \"width\": %d, \"height\": %d, \"fx\": %g, \"fy\": %g, \"cx\": %g, \"cy\": %g,\n"
          " \"distortion\": [0, 0, 0, 0, 0]}\n",
          WIDTH, HEIGHT, FOCAL, FOCAL, CX, CY);
  fclose(f);
  f = open_file("sphere.json");
  fprintf(f,
          "{\"format\": \"halflight-sphere\", \"version\": 1, \"center_m\": [%g, %g, %g],\n"
          " \"radius_m\": %g}\n",
          CENTER_M[0], CENTER_M[1], CENTER_M[2], RADIUS_M);
  fclose(f);
}

static void write_normals(void)
{
  static float map[WIDTH * HEIGHT * 3];
  for (int i = 0; i < WIDTH * HEIGHT; i++) {
    double n[3], v[3];
    /* pixels that lie wholly on the ball: the rim's mix with the background */
    if (hit(i % WIDTH, i / WIDTH, n, v) && dot(n, v) > 0.3)
      for (int k = 0; k < 3; k++)
        map[3 * i + k] = (float)n[k];
  }
  write_pfm("normals.pfm", map, 3);
}

static void write_frame(const options *o)
{
  static float data[WIDTH * HEIGHT * 3];
  int spots = o->spots;
  for (int i = 0; i < WIDTH * HEIGHT; i++) {
    double n[3], v[3];
    const int on = hit(i % WIDTH, i / WIDTH, n, v);
    const int spoilt = on && i % 7 == 0 && spots > 0;
    spots -= spoilt;
    for (int c = 0; c < o->channels; c++)
      data[i * o->channels + c] = spoilt ? NAN : pixel(o, i % WIDTH, i / WIDTH, c);
  }
  const size_t length = strlen(o->frame);
  if (length > 6 && strcmp(o->frame + length - 6, ".8.png") == 0)
    write_png(o->frame, data, o->channels, 1);
  else if (length > 4 && strcmp(o->frame + length - 4, ".png") == 0)
    write_png(o->frame, data, o->channels, 2);
  else
    write_pfm(o->frame, data, o->channels);
}

static void set(options *o, const char *word)
{
  const char *value = strchr(word, '=');
  const size_t n = value ? (size_t)(value - word) : 0;
  const struct {
    const char *name;
    double *to;
  } numbers[] = {{"gloss", &o->gloss},
                 {"diffuse", &o->diffuse},
                 {"specular", &o->specular},
                 {"background", &o->background},
                 {"gain", &o->gain}};
  if (!value++)
    fail(word);
  for (size_t i = 0; i < sizeof numbers / sizeof *numbers; i++) {
    if (strlen(numbers[i].name) == n && strncmp(word, numbers[i].name, n) == 0) {
      *numbers[i].to = strtod(value, NULL);
      return;
    }
  }
  if (strncmp(word, "frame=", 6) == 0)
    o->frame = value;
  else if (strncmp(word, "fill=", 5) == 0)
    o->fill = value;
  else if (strncmp(word, "channels=", 9) == 0)
    o->channels = value[0] == '1' ? 1 : 3;
  else if (strncmp(word, "spots=", 6) == 0)
    o->spots = (int)strtol(value, NULL, 10);
  else if (strncmp(word, "light=", 6) != 0 ||
           sscanf(value, "%lf,%lf,%lf", &o->light[0], &o->light[1], &o->light[2]) != 3)
    fail(word);
}

int main(int argc, char **argv)
{
  options o = {"frame.pfm", "ball", {0.3, -0.4, -0.8}, 80, 0.5, 0.4, 0.02, 1, 3, 0};
  for (int i = 1; i < argc; i++)
    set(&o, argv[i]);
  unit(o.light);
  write_geometry();
  write_normals();
  write_frame(&o);
  return 0;
}
