/* Meshes as normal maps: a tessellated sphere against the exact one, hidden surfaces, refusals. */
#include <stdlib.h>
#include <string.h>

#include "halflight/relight.h"
#include "halflight/vec3.h"
#include "near.h"

enum { RINGS = 64, SEGMENTS = 128 };

/* A unit sphere of rings x segments quads, exact normals at the vertices. */
static hl_mesh sphere(void)
{
  hl_mesh m = {.n_vertices = (RINGS + 1) * SEGMENTS, .n_faces = 2 * RINGS * SEGMENTS};
  m.position = malloc((size_t)m.n_vertices * 3 * sizeof(double));
  m.normal = malloc((size_t)m.n_vertices * 3 * sizeof(double));
  m.face = malloc((size_t)m.n_faces * 3 * sizeof(int));
  for (int i = 0; i <= RINGS; i++)
    for (int k = 0; k < SEGMENTS; k++) {
      const double theta = 3.14159265358979 * i / RINGS, phi = 6.28318530717959 * k / SEGMENTS;
      const double n[3] = {sin(theta) * cos(phi), sin(theta) * sin(phi), cos(theta)};
      memcpy(m.position + 3 * (i * SEGMENTS + k), n, sizeof n);
      memcpy(m.normal + 3 * (i * SEGMENTS + k), n, sizeof n);
    }
  int *f = m.face;
  for (int i = 0; i < RINGS; i++)
    for (int k = 0; k < SEGMENTS; k++) {
      const int a = i * SEGMENTS + k, b = i * SEGMENTS + (k + 1) % SEGMENTS;
      const int quad[6] = {a, a + SEGMENTS, b, b, a + SEGMENTS, b + SEGMENTS};
      memcpy(f, quad, sizeof quad);
      f += 6;
    }
  return m;
}

/* Facets of 2.8 deg: the interpolated normal is off by less than that squared over 8. */
static void test_a_sphere_is_a_sphere(void **state)
{
  (void)state;
  enum { SIDE = 100 };
  const double view[3] = {0.3, -0.5, 0.8};
  const double radius = 0.5 * 0.96 * SIDE; /* 2 % margin on each side */
  hl_mesh mesh = sphere();
  hl_viewing v;
  hl_frame f = {0};
  hl_viewing_along(NULL, view, false, &v);
  assert_int_equal(hl_normals_of_mesh(NULL, &mesh, &v, SIDE, SIDE, &f), HL_OK);
  int compared = 0;
  for (int row = 0; row < SIDE; row++)
    for (int column = 0; column < SIDE; column++) {
      const double x = (column - 0.5 * (SIDE - 1)) / radius, y = (row - 0.5 * (SIDE - 1)) / radius;
      const double under = 1 - x * x - y * y;
      const float *p = f.radiance + 3 * (row * SIDE + column);
      const double got[3] = {p[0], p[1], p[2]};
      double want[3];
      if (under < -0.02)
        assert_near(hl_norm(got), 0, 0);
      if (under < 0.05)
        continue;
      for (int i = 0; i < 3; i++)
        want[i] = x * v.right[i] + y * v.down[i] + sqrt(under) * v.view[i];
      assert_near(hl_angle(got, want), 0, 0.01);
      compared++;
    }
  assert_true(compared > 6000);
  hl_frame_free(&f);
  hl_mesh_free(&mesh);
}

/* Two parallel triangles with different normals: the nearer one is seen, in any order. */
static void test_the_nearer_face_hides_the_other(void **state)
{
  (void)state;
  for (int order = 0; order < 2; order++) {
    double position[18] = {-1, -1, 0, 3, -1, 0, -1, 3, 0, -1, -1, 1, 3, -1, 1, -1, 3, 1};
    double normal[18] = {0};
    int face[6] = {0, 1, 2, 3, 4, 5};
    int swapped[6] = {3, 4, 5, 0, 1, 2};
    for (int i = 0; i < 6; i++)
      normal[3 * i + (i < 3 ? 2 : 0)] = 1; /* far: z, near: x, turned to the silhouette */
    hl_mesh mesh = {6, 2, position, normal, order ? swapped : face};
    hl_viewing v;
    hl_frame f = {0};
    hl_viewing_along(NULL, NULL, false, &v);
    assert_int_equal(hl_normals_of_mesh(NULL, &mesh, &v, 20, 20, &f), HL_OK);
    const float *p = f.radiance + 3 * (15 * 20 + 4);
    assert_near(p[0], 1, 1e-5);
    assert_near(p[2], 1e-3, 1e-5);
    hl_frame_free(&f);
  }
}

static void test_refusals(void **state)
{
  (void)state;
  hl_mesh mesh = sphere();
  hl_viewing v;
  hl_frame f = {0};
  hl_ctx ctx = {0};
  hl_viewing_along(NULL, NULL, false, &v);
  assert_int_equal(hl_normals_of_mesh(&ctx, &mesh, &v, 0, 5, &f), HL_ERR_ARG);
  assert_int_equal(hl_normals_of_mesh(&ctx, &mesh, &v, 5, 20000, &f), HL_ERR_ARG);
  for (int i = 0; i < 3 * mesh.n_faces; i++)
    mesh.face[i] = 7; /* every face a point */
  assert_int_equal(hl_normals_of_mesh(&ctx, &mesh, &v, 20, 20, &f), HL_ERR_DEGENERATE);
  assert_null(f.radiance);
  hl_mesh_free(&mesh);
  hl_mesh_free(NULL);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_a_sphere_is_a_sphere),
      cmocka_unit_test(test_the_nearer_face_hides_the_other),
      cmocka_unit_test(test_refusals),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
