/* The report of a fit of samples, from FIT.json. */
#include <math.h>
#include <string.h>

#include "report.h"

static void put_terms(hl_page *page, const json_t *terms)
{
  static const char *const columns[] = {"Term", "Direction", "Gain [% of variance]"};
  hl_page_heading(page, "Terms");
  hl_page_table_begin(page, columns, 3, 1);
  for (size_t i = 0; i < json_array_size(terms); i++) {
    const json_t *term = json_array_get(terms, i);
    const char *about = hl_json_text_of(term, "name");
    double a[3];
    char name[120];
    hl_json_doubles(term, "direction", 3, a);
    snprintf(name, sizeof name, "%s%s%s", hl_json_text_of(term, "role"), about[0] ? " about " : "",
             about);
    hl_page_row_begin(page, false, name);
    hl_page_cell(page, "Direction", true, "%.5f %.5f %.5f", a[0], a[1], a[2]);
    if (isfinite(hl_json_double(term, "gain")))
      hl_page_cell(page, "Gain [% of variance]", true, "%.3g", 100 * hl_json_double(term, "gain"));
    else
      hl_page_cell(page, "Gain [% of variance]", true, "not stated");
    hl_page_row_end(page);
  }
  hl_page_table_end(page);
}

hl_status hl_report_fit(hl_ctx *ctx, const hl_report_source *source, hl_page *page)
{
  const json_t *d = source->document, *unique = json_object_get(d, "identifiability");
  const json_t *times = json_object_get(d, "timing_ms");
  const char *status = hl_json_text_of(d, "status");
  const bool good = strcmp(status, "ok") == 0;
  if (!json_is_array(json_object_get(d, "terms")))
    return hl_fail(ctx, HL_ERR_FORMAT, "%s: terms is no list", source->path);
  hl_page_element(page, "h1", NULL, "Reflectance fit");
  hl_page_verdict(page, good, good ? "The fit can be used." : "The fit is not to be trusted.",
                  json_object_get(d, "reasons"), NULL);
  hl_page_picture(page, "fit");
  hl_page_no_pictures(page, "halflight fit --out DIR/");
  put_terms(page, json_object_get(d, "terms"));
  hl_page_heading(page, "The fit");
  hl_page_facts_begin(page);
  hl_page_fact(page, "Model", "%s", hl_json_text_of(d, "model"));
  hl_page_fact(page, "Relative error", "%.3g %%", 100 * hl_json_double(d, "relative_error"));
  hl_page_fact(page, "Unexplained variance", "%.3g %%",
               100 * hl_json_double(d, "unexplained_variance"));
  hl_page_fact(page, "Reflectance", "%s", hl_json_text_of(unique, "verdict"));
  hl_page_fact(page, "By", "%s", hl_json_text_of(unique, "proposition"));
  hl_page_fact(page, "Stays free", "%s", hl_json_text_of(unique, "free"));
  if (json_is_object(times))
    hl_page_fact(page, "Time", "read %.1f, estimate %.1f ms", hl_json_double(times, "read"),
                 hl_json_double(times, "estimate"));
  hl_page_facts_end(page);
  hl_page_notes(page, "Used", json_object_get(d, "used"));
  hl_page_notes(page, "Left out", json_object_get(d, "left_out"));
  return HL_OK;
}
