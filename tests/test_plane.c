/* Homographies by least squares: exact where the points are, and what is refused. */
#include "../calib/plane.h"

#include "near.h"

/* A plane seen steeply: 6 x 5 points, x to 8, pixels about (300, 200). */
static int points(double board[30][2], double pixel[30][2])
{
  int n = 0;
  for (int y = 0; y < 5; y++)
    for (int x = 0; x < 6; x++) {
      const double u = 1.6 * x;
      const double v = 0.7 * y - 1;
      const double w = 1 + 0.05 * u - 0.11 * v;
      board[n][0] = u;
      board[n][1] = v;
      pixel[n][0] = (300 + 40 * u + 3 * v) / w;
      pixel[n][1] = (200 - 9 * u + 52 * v) / w;
      n++;
    }
  return n;
}

static void test_exact_points_come_back(void **state)
{
  (void)state;
  double board[30][2];
  double pixel[30][2];
  hl_plane plane;
  const int n = points(board, pixel);
  for (int used = n; used >= n - 10; used -= 5) {
    assert_true(hl_plane_fit((const double(*)[2])board, (const double(*)[2])pixel, used, &plane));
    for (int i = 0; i < n; i++) {
      double at[2];
      hl_plane_at(&plane, board[i], at);
      assert_near(at[0], pixel[i][0], 1e-7);
      assert_near(at[1], pixel[i][1], 1e-7);
    }
  }
}

/* Noise of the pixels is averaged: the fit lies nearer to the truth than the points, by about
 * sqrt(8 / 60) of the noise. */
static void test_noise_is_averaged(void **state)
{
  (void)state;
  double board[30][2];
  double truth[30][2];
  double pixel[30][2];
  test_random random = {5};
  double sum = 0;
  const int n = points(board, truth);
  for (int round = 0; round < 200; round++) {
    hl_plane plane;
    for (int i = 0; i < n; i++)
      for (int k = 0; k < 2; k++)
        pixel[i][k] = truth[i][k] + 0.1 * random_normal(&random);
    assert_true(hl_plane_fit((const double(*)[2])board, (const double(*)[2])pixel, n, &plane));
    for (int i = 0; i < n; i++) {
      double at[2];
      hl_plane_at(&plane, board[i], at);
      sum += (at[0] - truth[i][0]) * (at[0] - truth[i][0]);
      sum += (at[1] - truth[i][1]) * (at[1] - truth[i][1]);
    }
  }
  const double rms = sqrt(sum / (200 * 2 * n));
  assert_near(rms, 0.1 * sqrt(8.0 / 60), 0.002);
}

static void test_what_determines_no_plane_is_refused(void **state)
{
  (void)state;
  const double board[4][2] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  const double in_a_row[5][2] = {{0, 0}, {1, 1}, {2, 2}, {3, 3}, {4, 4}};
  const double pixel[5][2] = {{0, 0}, {10, 0}, {10, 10}, {0, 10}, {3, 3}};
  const double same[4][2] = {{7, 7}, {7, 7}, {7, 7}, {7, 7}};
  hl_plane plane;
  assert_true(hl_plane_fit(board, pixel, 4, &plane));
  assert_false(hl_plane_fit(board, pixel, 3, &plane));
  assert_false(hl_plane_fit(in_a_row, pixel, 5, &plane));
  assert_false(hl_plane_fit(same, pixel, 4, &plane));
  const double none[4][2] = {{0, 0}, {10, NAN}, {10, 10}, {0, 10}};
  assert_false(hl_plane_fit(board, none, 4, &plane));
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_exact_points_come_back),
      cmocka_unit_test(test_noise_is_averaged),
      cmocka_unit_test(test_what_determines_no_plane_is_refused),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
