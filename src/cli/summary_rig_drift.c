/* Two sessions of a rig in words: the verdict, what moved by how much, what was not compared. */
#include <math.h>
#include <stdio.h>
#include <string.h>

#include "drift_rig.h"
#include "summary.h"

enum { TEXT_MAX = 320 };

/* "0.5 mm", "-10 %", "1.02 deg" */
static void write_figure(const hl_rig_cause *c, double figure, bool sign, char *out, size_t size)
{
  if (c->part == HL_RIG_SPHERE)
    snprintf(out, size, "%.3g mm", 1e3 * figure);
  else if (c->part == HL_RIG_INTENSITY || c->part == HL_RIG_EXPOSURE)
    snprintf(out, size, "%s%.3g %%", !sign ? "" : c->change[0] < 1 ? "-" : "+", 100 * figure);
  else
    snprintf(out, size, "%.3g %s", figure, c->unit);
}

static void write_what(const hl_rig_cause *c, char *out, size_t size)
{
  static const char *const quantity[] = {"mount turned", "intrinsics", "sphere moved",
                                         "direction",    "intensity",  "exposure"};
  if (*c->name)
    snprintf(out, size, "light %.60s %s", c->name, quantity[c->part]);
  else
    snprintf(out, size, "%s", quantity[c->part]);
}

void hl_summary_rig_verdict(const hl_rig_drift *drift, char *out, size_t size)
{
  size_t n = (size_t)snprintf(out, size, "%s", drift->drifted ? "drifted" : "same");
  if (!drift->drifted) {
    snprintf(out + n, size - n, ": the difference has probability %.2g where nothing moved",
             drift->significance);
    return;
  }
  const char *link = ": ";
  for (int i = 0; i < drift->n_causes && n + 130 < size; i++) {
    char what[100], figure[40];
    if (!drift->cause[i].moved)
      continue;
    write_what(&drift->cause[i], what, sizeof what);
    write_figure(&drift->cause[i], drift->cause[i].figure, true, figure, sizeof figure);
    n += (size_t)snprintf(out + n, size - n, "%s%s by %s", link, what, figure);
    link = ", ";
  }
}

static void print_cause(FILE *out, const char *label, const hl_rig_cause *c)
{
  char text[TEXT_MAX], what[100], figure[40], threshold[40] = "";
  write_what(c, what, sizeof what);
  write_figure(c, c->figure, true, figure, sizeof figure);
  if (!isnan(c->threshold))
    write_figure(c, c->threshold, false, threshold, sizeof threshold);
  snprintf(text, sizeof text,
           c->moved ? "%s by %s; noise explains %s" : "%s: %s, and noise explains %s", what, figure,
           *threshold ? threshold : "none");
  hl_summary_line(out, label, text);
}

static void print_quiet_lights(FILE *out, const hl_rig_drift *drift, hl_rig_part part,
                               const char *quantity)
{
  double most = 0;
  int n = 0;
  for (int i = 0; i < drift->n_causes; i++)
    if (drift->cause[i].part == part && !drift->cause[i].moved) {
      most = fmax(most, drift->cause[i].figure);
      n++;
    }
  char text[TEXT_MAX];
  if (n == 0)
    return;
  if (part == HL_RIG_INTENSITY)
    snprintf(text, sizeof text, "%s of %d lights: at most %.2g %%", quantity, n, 100 * most);
  else
    snprintf(text, sizeof text, "%s of %d lights: at most %.2g deg", quantity, n, most);
  hl_summary_line(out, "", text);
}

void hl_summary_rig_drift(FILE *out, const hl_rig_drift *drift)
{
  char text[TEXT_MAX];
  snprintf(text, sizeof text,
           "%s: %d lights, %d tests; where nothing moved, as large a difference has probability "
           "%.2g at most (alarm below %g)",
           drift->drifted ? "DRIFTED" : "same", drift->n_matched, drift->n_tests,
           drift->significance, drift->false_alarm);
  hl_summary_line(out, "verdict", text);
  const char *label = "moved";
  for (int i = 0; i < drift->n_causes; i++)
    if (drift->cause[i].moved) {
      print_cause(out, label, &drift->cause[i]);
      label = "";
    }
  label = "unmoved";
  for (int i = 0; i < drift->n_causes; i++) {
    const hl_rig_part part = drift->cause[i].part;
    if (drift->cause[i].moved || part == HL_RIG_DIRECTION || part == HL_RIG_INTENSITY)
      continue;
    print_cause(out, label, &drift->cause[i]);
    label = "";
  }
  print_quiet_lights(out, drift, HL_RIG_DIRECTION, "directions");
  print_quiet_lights(out, drift, HL_RIG_INTENSITY, "intensities");
  hl_summary_notes(out, "notes", &drift->notes);
}
