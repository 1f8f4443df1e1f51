/* What the build says of itself. */
#include <stdio.h>
#include <string.h>

#include "halflight/info.h"
#include "near.h"

static const hl_feature *feature(const char *name)
{
  int n = 0;
  const hl_feature *all = hl_features(&n);
  for (int i = 0; i < n; i++)
    if (strcmp(all[i].name, name) == 0)
      return &all[i];
  return NULL;
}

static void test_version_has_three_numbers(void **state)
{
  (void)state;
  int major = -1, minor = -1, patch = -1;
  assert_int_equal(sscanf(hl_version(), "%d.%d.%d", &major, &minor, &patch), 3);
}

static void test_features_are_described(void **state)
{
  (void)state;
  const char *const names[] = {"jansson", "libyaml",  "libmd",  "cminpack", "OpenMP",
                               "OpenCV",  "AprilTag", "assimp", "libcamera"};
  for (size_t i = 0; i < sizeof names / sizeof *names; i++) {
    const hl_feature *f = feature(names[i]);
    assert_non_null(f);
    assert_true(f->gives[0] && f->option);
  }
  assert_string_equal(feature("AprilTag")->option, "-DHL_WITH_APRILTAG=ON");
  assert_string_equal(feature("libcamera")->gives, "capture");
  assert_string_equal(feature("OpenCV")->option, "-DHL_WITH_OPENCV=ON");
  assert_non_null(feature("jansson")->version);
  assert_non_null(feature("libyaml")->version);
  assert_non_null(feature("libmd")->version);
}

static void test_versions_follow_the_build(void **state)
{
  (void)state;
#ifdef HL_HAVE_OPENCV
  assert_true(feature("OpenCV")->version[0] >= '3');
#else
  assert_null(feature("OpenCV")->version);
#endif
#ifdef HL_HAVE_LIBCAMERA
  assert_true(feature("libcamera")->version[0]);
#else
  assert_null(feature("libcamera")->version);
#endif
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_version_has_three_numbers),
      cmocka_unit_test(test_features_are_described),
      cmocka_unit_test(test_versions_follow_the_build),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
