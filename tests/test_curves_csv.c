/* The curves as a table. */
#include "files.h"
#include "halflight/export.h"

static void test_write(void **state)
{
  char path[TEST_PATH_MAX];
  path_in(state, "curves.csv", path);
  static hl_light light;
  light.n_curves = 2;
  light.curves[0] = (hl_curve){.lobe = "diffuse",
                               .channel = "r",
                               .n = 2,
                               .angle_rad = {0, 1.5707963267948966},
                               .value = {0.5, 0}};
  light.curves[1] = (hl_curve){.lobe = "specular",
                               .channel = "grey",
                               .n = 1,
                               .angle_rad = {0.017453292519943295},
                               .value = {1.25e-5}};
  assert_int_equal(hl_curves_csv_write(NULL, path, &light), HL_OK);
  size_t n = 0;
  char *text = get_file(path, &n);
  assert_string_equal(text, "lobe,channel,quantity,angle_deg,value\n"
                            "diffuse,r,radiance,0,0.5\n"
                            "diffuse,r,radiance,90,0\n"
                            "specular,grey,radiance,1,1.25e-05\n");
  free(text);
}

static void test_write_without_curves_has_its_head(void **state)
{
  char path[TEST_PATH_MAX];
  path_in(state, "curves.csv", path);
  static const hl_light light;
  assert_int_equal(hl_curves_csv_write(NULL, path, &light), HL_OK);
  size_t n = 0;
  char *text = get_file(path, &n);
  assert_string_equal(text, "lobe,channel,quantity,angle_deg,value\n");
  free(text);
}

static void test_write_refuses_where_there_is_no_folder(void **state)
{
  char path[TEST_PATH_MAX];
  path_in(state, "gone/curves.csv", path);
  static const hl_light light;
  hl_ctx ctx = {0};
  assert_int_equal(hl_curves_csv_write(&ctx, path, &light), HL_ERR_IO);
  assert_says(ctx.msg, "gone/curves.csv: cannot create: ");
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_write),
      cmocka_unit_test(test_write_without_curves_has_its_head),
      cmocka_unit_test(test_write_refuses_where_there_is_no_folder),
  };
  return cmocka_run_group_tests(tests, folder_new, folder_free);
}
