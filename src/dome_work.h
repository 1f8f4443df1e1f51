/* What the shapes of a dome share. Private. */
#ifndef HL_DOME_WORK_H
#define HL_DOME_WORK_H

#include "halflight/dome.h"

enum { HL_DOME_SCORED_MAX = 64, HL_DOME_SIDES_MAX = 2 + HL_DOME_RINGS_MAX };

typedef struct hl_dome_data {
  const double *x; /* shape (n,3) */
  int n;
  bool positions;
  double sigma;       /* no shape holds more closely */
  double *log_plain;  /* shape (n), log density of lights without order at each */
  int plain_unknowns; /* of that density */
  double *room;       /* shape (4,n) */
  int n_scored;       /* lights by which candidates are compared, evenly thinned */
  int scored[HL_DOME_SCORED_MAX];
} hl_dome_data;

/* Normal equations of a step: upper triangle of J'J, -J'r, r'r and its number of coordinates. */
typedef struct hl_dome_system {
  double a[HL_DOME_SIDES_MAX][HL_DOME_SIDES_MAX], b[HL_DOME_SIDES_MAX];
  double squares;
  int coordinates;
} hl_dome_system;

void hl_dome_add_row(hl_dome_system *s, const double *row, double r, int unknowns);
/* The step, in s->b. */
void hl_dome_solve(hl_dome_system *s, int unknowns);

/* Deviations beyond which a light is off, for residuals of 1, 2 and 3 coordinates: each is passed by
 * about one normal residual in 2000. */
double hl_dome_cut(int coordinates);

/* Coordinates of a shape's residual, and its unknowns beside deviation and share of lights off. */
int hl_dome_coordinates(const hl_dome_fit *fit, bool positions);
int hl_dome_unknowns(const hl_dome_fit *fit, bool positions);

/* dome_plain.c: fills log_plain and plain_unknowns. */
void hl_dome_plain(hl_dome_data *data);

/* Log odds of the shape against lights without order, with fit->sigma: all lights, or those scored. */
double hl_dome_evidence(const hl_dome_data *data, const hl_dome_fit *fit, bool all);

/* Refines the candidates and keeps the one with most evidence; false: none of them can be refined. */
bool hl_dome_best(const hl_dome_data *data, bool (*refine)(const hl_dome_data *, hl_dome_fit *),
                  hl_dome_fit *candidate, int n, hl_dome_fit *out);

/* Distance of x from the shape, and the log density of lights on it where x is nearest, for
 * fit->sigma. */
double hl_dome_nearest(const hl_dome_data *data, const hl_dome_fit *fit, const double x[3],
                       double *log_peak);
double hl_dome_rings_nearest(const hl_dome_fit *fit, const double x[3], double *log_peak);
double hl_dome_grid_nearest(const hl_dome_fit *fit, bool positions, const double x[3], int node[2],
                            double *log_peak);
double hl_dome_sphere_nearest(const hl_dome_fit *fit, const double x[3], double *log_peak);
double hl_dome_circle_nearest(const hl_dome_fit *fit, const double x[3], double *log_peak);

/* false: too few lights, or none of the candidates can be laid through them. */
bool hl_dome_fit_rings(const hl_dome_data *data, hl_dome_fit *out);
bool hl_dome_fit_grid(const hl_dome_data *data, hl_dome_fit *out);
bool hl_dome_fit_sphere(const hl_dome_data *data, hl_dome_fit *out);
bool hl_dome_fit_circle(const hl_dome_data *data, hl_dome_fit *out);

/* sigma that three quarters of the scored lights agree with, for a candidate. */
double hl_dome_rough_sigma(const hl_dome_data *data, const hl_dome_fit *fit);

/* sigma from a sum of squares over `coordinates` of them, never below what is known. */
double hl_dome_sigma(const hl_dome_data *data, double squares, int coordinates, int unknowns);

#endif
