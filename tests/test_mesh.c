/* Meshes from files: a cube's facets, smooth normals, refusals. */
#include "files.h"
#include "halflight/relight.h"
#include "halflight/vec3.h"

static const char tetrahedron[] = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
                                  "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

static void read_text(void **state, const char *name, const char *text, hl_status due, hl_mesh *out,
                      const char *message)
{
  char path[TEST_PATH_MAX];
  hl_ctx ctx = {0};
  path_in(state, name, path);
  put_file(path, text, strlen(text));
  assert_int_equal(hl_mesh_read(&ctx, path, out), due);
  if (message) {
    assert_says(ctx.msg, path);
    assert_says(ctx.msg, message);
  }
}

/* Edges of 55 to 90 deg between outward normals of 90 deg or more stay sharp: every face is flat. */
static void test_sharp_edges_stay(void **state)
{
  hl_mesh m = {0};
  read_text(state, "t.obj", tetrahedron, HL_OK, &m, NULL);
  assert_int_equal(m.n_faces, 4);
  for (int f = 0; f < m.n_faces; f++) {
    const double *p[3];
    double a[3], b[3], n[3];
    for (int i = 0; i < 3; i++)
      p[i] = m.position + 3 * m.face[3 * f + i];
    hl_add_scaled(p[1], -1, p[0], a);
    hl_add_scaled(p[2], -1, p[0], b);
    hl_cross(a, b, n);
    for (int i = 0; i < 3; i++)
      assert_near(hl_angle(m.normal + 3 * m.face[3 * f + i], n), 0, 1e-3);
  }
  hl_mesh_free(&m);
}

/* The file's own normals are kept; a polygon is cut into triangles. */
static void test_normals_of_the_file_and_polygons(void **state)
{
  static const char square[] = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvn 0.6 0 0.8\n"
                               "f 1//1 2//1 3//1 4//1\n";
  hl_mesh m = {0};
  read_text(state, "square.obj", square, HL_OK, &m, NULL);
  assert_int_equal(m.n_faces, 2);
  for (int i = 0; i < m.n_vertices; i++) {
    assert_near(m.normal[3 * i], 0.6, 1e-6);
    assert_near(m.normal[3 * i + 2], 0.8, 1e-6);
  }
  hl_mesh_free(&m);
}

static void test_refusals(void **state)
{
  hl_mesh m = {0};
  char path[TEST_PATH_MAX];
  hl_ctx ctx = {0};
  read_text(state, "points.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\n", HL_ERR_FORMAT, &m, "face");
  read_text(state, "empty.obj", "\n", HL_ERR_FORMAT, &m, "mesh");
  read_text(state, "words.obj", "this is no mesh at all\n", HL_ERR_FORMAT, &m, "mesh");
  read_text(state, "nan.obj", "v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", HL_ERR_FORMAT, &m,
            "finite");
  read_text(state, "index.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", HL_ERR_FORMAT, &m, "range");
  path_in(state, "missing.obj", path);
  assert_int_equal(hl_mesh_read(&ctx, path, &m), HL_ERR_IO);
  assert_says(ctx.msg, path);
  assert_null(m.position);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_sharp_edges_stay),
      cmocka_unit_test(test_normals_of_the_file_and_polygons),
      cmocka_unit_test(test_refusals),
  };
  return cmocka_run_group_tests(tests, folder_new, folder_free);
}
