/* The report of a drift check, of two cameras or of two rigs, from DRIFT.json. */
#include <math.h>
#include <string.h>

#include "report.h"

/* "light 05 direction", "focal length": whichever names the part has. */
static void name_of(const json_t *cause, char *out, size_t size)
{
  const char *part = hl_json_text_of(cause, "part");
  const char *name = hl_json_text_of(cause, "name");
  if (part[0])
    snprintf(out, size, "%s: %s", hl_json_text_of(cause, "what"), part);
  else
    snprintf(out, size, "%s%s%s: %s", hl_json_text_of(cause, "what"), name[0] ? " " : "", name,
             hl_json_text_of(cause, "quantity"));
}

static void put_cause(hl_page *page, const json_t *cause)
{
  const char *unit = hl_json_text_of(cause, "unit");
  const bool moved = hl_json_is_true(cause, "moved"), metres = strcmp(unit, "m") == 0;
  const bool share = strcmp(unit, "relative") == 0;
  const char *shown = metres ? "mm" : share ? "%" : unit;
  const double factor = metres ? 1e3 : share ? 100 : 1;
  char name[160];
  name_of(cause, name, sizeof name);
  hl_page_row_begin(page, moved, name);
  hl_page_cell(page, "Verdict", false, "%s", moved ? "moved" : "no change seen");
  hl_page_cell(page, "Change", true, "%.3g %s", factor * hl_json_double(cause, "figure"), shown);
  hl_page_cell(page, "Noise explains up to", true, "%.3g %s",
               factor * hl_json_double(cause, "threshold"), shown);
  const double p = hl_json_double(cause, "significance");
  if (p < 1e-300)
    hl_page_cell(page, "Probability if nothing moved", true, "below 1e-300");
  else
    hl_page_cell(page, "Probability if nothing moved", true, "%.2g", p);
  hl_page_row_end(page);
}

static void put_causes(hl_page *page, const json_t *document)
{
  static const char *const columns[] = {"What", "Verdict", "Change", "Noise explains up to",
                                        "Probability if nothing moved"};
  static const char *const lists[] = {"causes", "unmoved"};
  hl_page_heading(page, "What was compared");
  hl_page_table_begin(page, columns, 5, 2);
  for (int k = 0; k < 2; k++) {
    const json_t *list = json_object_get(document, lists[k]);
    for (size_t i = 0; i < json_array_size(list); i++)
      put_cause(page, json_array_get(list, i));
  }
  hl_page_table_end(page);
}

static void put_projection(hl_page *page, const json_t *projection)
{
  if (!json_is_object(projection))
    return;
  hl_page_heading(page, "Projection");
  hl_page_facts_begin(page);
  hl_page_fact(page, "Mean difference", "%.3g px", hl_json_double(projection, "mean"));
  hl_page_fact(page, "Largest difference", "%.3g px", hl_json_double(projection, "max"));
  hl_page_facts_end(page);
}

hl_status hl_report_drift(hl_ctx *ctx, const hl_report_source *source, hl_page *page)
{
  const json_t *d = source->document;
  const bool good = strcmp(hl_json_text_of(d, "verdict"), "same") == 0;
  if (!json_is_array(json_object_get(d, "causes")))
    return hl_fail(ctx, HL_ERR_FORMAT, "%s: causes is no list", source->path);
  hl_page_element(page, "h1", NULL, "Drift check");
  char text[200];
  snprintf(text, sizeof text,
           "An alarm is given where so large a difference has a probability below %.3g if nothing "
           "moved. %s",
           hl_json_double(d, "false_alarm"),
           good ? "What is smaller than its noise cannot be seen."
                : "Calibrate anew what moved before it is used.");
  hl_page_verdict(page, good, good ? "No change is seen." : "Something has changed.", NULL, text);
  hl_page_picture(page, "drift");
  hl_page_no_pictures(page, "halflight drift --out DIR");
  put_causes(page, d);
  put_projection(page, json_object_get(d, "projection_difference_px"));
  hl_page_notes(page, "Notes", json_object_get(d, "notes"));
  return HL_OK;
}
