/* Lines of notes: as many as there is room for, each within its own. */
#include <stdio.h>
#include <string.h>

#include "halflight/notes.h"
#include "near.h"

static void test_notes_fill_up_and_no_further(void **state)
{
  (void)state;
  hl_notes notes = {0};
  char want[40];
  for (int i = 0; i < HL_NOTES_MAX + 3; i++)
    hl_notes_add(&notes, "term", "number %d", i);
  assert_int_equal(notes.n, HL_NOTES_MAX);
  for (int i = 0; i < HL_NOTES_MAX; i++) {
    snprintf(want, sizeof want, "number %d", i);
    assert_string_equal(notes.note[i].what, "term");
    assert_string_equal(notes.note[i].why, want);
  }
}

static void test_long_words_are_cut_within_bounds(void **state)
{
  (void)state;
  hl_notes notes = {0};
  char longest[2 * HL_NOTE_TEXT_MAX];
  memset(longest, 'x', sizeof longest);
  longest[sizeof longest - 1] = '\0';
  hl_notes_add(&notes, longest, "%s", longest);
  assert_int_equal(strlen(notes.note[0].what), sizeof notes.note[0].what - 1);
  assert_int_equal(strlen(notes.note[0].why), sizeof notes.note[0].why - 1);
}

int main(void)
{
  const struct CMUnitTest tests[] = {
      cmocka_unit_test(test_notes_fill_up_and_no_further),
      cmocka_unit_test(test_long_words_are_cut_within_bounds),
  };
  return cmocka_run_group_tests(tests, NULL, NULL);
}
