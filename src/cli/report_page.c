/* HTML in memory. */
#include "report_page.h"

#include <ctype.h>
#include <math.h>
#include <stdarg.h>
#include <string.h>

enum { TEXT_MAX = 1024 };

void hl_page_text(hl_page *page, const char *text)
{
  for (const char *c = text; *c; c++) {
    const unsigned char code = (unsigned char)*c;
    const char *entity = *c == '&'                                                ? "&amp;"
                         : *c == '<'                                              ? "&lt;"
                         : *c == '>'                                              ? "&gt;"
                         : *c == '"'                                              ? "&quot;"
                         : (code < 32 && *c != '\n' && *c != '\t') || code == 127 ? "\357\277\275"
                                                                                  : NULL;
    if (entity)
      fputs(entity, page->out);
    else
      fputc(*c, page->out);
  }
}

/* The next number in `text` that is none, as printf writes it; NULL where there is no more. */
static char *next_nan(char *text)
{
  for (char *at = strstr(text, "nan"); at; at = strstr(at + 3, "nan")) {
    char *start = at > text && at[-1] == '-' ? at - 1 : at;
    if ((start == text || !isalnum((unsigned char)start[-1])) && !isalnum((unsigned char)at[3]))
      return start;
  }
  return NULL;
}

/* What a document does not state is said so. */
static void put_stated(hl_page *page, char *text)
{
  char *rest = text;
  for (char *none = next_nan(rest); none; none = next_nan(rest)) {
    const size_t length = *none == '-' ? 4 : 3;
    *none = '\0';
    hl_page_text(page, rest);
    hl_page_text(page, "(not stated)");
    rest = none + length;
  }
  hl_page_text(page, rest);
}

static void print_stated(hl_page *page, const char *format, va_list list)
{
  char text[TEXT_MAX];
  vsnprintf(text, sizeof text, format, list);
  put_stated(page, text);
}

void hl_page_printf(hl_page *page, const char *format, ...)
{
  va_list list;
  va_start(list, format);
  print_stated(page, format, list);
  va_end(list);
}

void hl_page_element(hl_page *page, const char *tag, const char *style, const char *text)
{
  if (style)
    fprintf(page->out, "<%s class=\"%s\">", tag, style);
  else
    fprintf(page->out, "<%s>", tag);
  hl_page_text(page, text);
  fprintf(page->out, "</%s>\n", tag);
}

void hl_page_heading(hl_page *page, const char *text)
{
  hl_page_element(page, "h2", NULL, text);
}

/* A reason is a text, or {"what", "why"}. */
static void reason_item(hl_page *page, const json_t *reason)
{
  fputs("<li>", page->out);
  if (json_is_string(reason)) {
    hl_page_text(page, json_string_value(reason));
  } else {
    hl_page_text(page, hl_json_text_of(reason, "what"));
    hl_page_text(page, ": ");
    hl_page_text(page, hl_json_text_of(reason, "why"));
  }
  fputs("</li>\n", page->out);
}

void hl_page_verdict(hl_page *page, bool good, const char *headline, const json_t *reasons,
                     const char *advice)
{
  fprintf(page->out, "<div class=\"verdict %s\">", good ? "good" : "bad");
  hl_page_element(page, "strong", NULL, headline);
  if (json_array_size(reasons) > 0) {
    fputs("<ul>\n", page->out);
    for (size_t i = 0; i < json_array_size(reasons); i++)
      reason_item(page, json_array_get(reasons, i));
    fputs("</ul>\n", page->out);
  }
  if (advice)
    hl_page_element(page, "p", NULL, advice);
  fputs("</div>\n", page->out);
}

void hl_page_facts_begin(hl_page *page)
{
  fputs("<table class=\"facts\"><tbody>\n", page->out);
}

void hl_page_fact(hl_page *page, const char *name, const char *format, ...)
{
  va_list list;
  fputs("<tr><th scope=\"row\">", page->out);
  hl_page_text(page, name);
  fputs("</th><td>", page->out);
  va_start(list, format);
  print_stated(page, format, list);
  va_end(list);
  fputs("</td></tr>\n", page->out);
}

void hl_page_facts_end(hl_page *page)
{
  fputs("</tbody></table>\n", page->out);
}

void hl_page_table_begin(hl_page *page, const char *const *columns, int n, int n_words)
{
  fputs("<div class=\"scroll\"><table class=\"stack\"><thead><tr>", page->out);
  for (int i = 0; i < n; i++) {
    fprintf(page->out, "<th scope=\"col\"%s>", i >= n_words ? " class=\"figure\"" : "");
    hl_page_text(page, columns[i]);
    fputs("</th>", page->out);
  }
  fputs("</tr></thead><tbody>\n", page->out);
}

void hl_page_row_begin(hl_page *page, bool bad, const char *head)
{
  fprintf(page->out, "<tr%s><th scope=\"row\">", bad ? " class=\"bad\"" : "");
  hl_page_text(page, head);
  fputs("</th>", page->out);
}

void hl_page_cell(hl_page *page, const char *column, bool figure, const char *format, ...)
{
  va_list list;
  fprintf(page->out, "<td%s data-of=\"", figure ? " class=\"figure\"" : "");
  hl_page_text(page, column);
  fputs("\">", page->out);
  va_start(list, format);
  print_stated(page, format, list);
  va_end(list);
  fputs("</td>", page->out);
}

void hl_page_row_end(hl_page *page)
{
  fputs("</tr>\n", page->out);
}

void hl_page_table_end(hl_page *page)
{
  fputs("</tbody></table></div>\n", page->out);
}

void hl_page_notes(hl_page *page, const char *heading, const json_t *notes)
{
  if (json_array_size(notes) == 0)
    return;
  hl_page_heading(page, heading);
  fputs("<table class=\"notes\"><tbody>\n", page->out);
  for (size_t i = 0; i < json_array_size(notes); i++) {
    const json_t *note = json_array_get(notes, i);
    const char *what =
        json_is_string(note) ? json_string_value(note) : hl_json_text_of(note, "what");
    hl_page_fact(page, what, "%s", hl_json_text_of(note, "why"));
  }
  hl_page_facts_end(page);
}

bool hl_page_picture(hl_page *page, const char *name)
{
  const json_t *pictures = json_object_get(page->evidence, "pictures");
  for (size_t i = 0; i < json_array_size(pictures); i++) {
    const json_t *p = json_array_get(pictures, i);
    if (strcmp(hl_json_text_of(p, "name"), name) != 0)
      continue;
    const bool vector = strcmp(hl_json_text_of(p, "kind"), "svg") == 0;
    fprintf(page->out, "<figure><img class=\"%s\" width=\"%d\" height=\"%d\" alt=\"",
            hl_json_is_true(p, "chart") ? "chart" : "photo", (int)hl_json_double(p, "width"),
            (int)hl_json_double(p, "height"));
    hl_page_text(page, hl_json_text_of(p, "title"));
    hl_page_text(page, ". ");
    hl_page_text(page, hl_json_text_of(p, "alt"));
    fprintf(page->out, "\" src=\"data:image/%s;base64,", vector ? "svg+xml" : "png");
    fputs(hl_json_text_of(p, "base64"), page->out);
    fputs("\">\n<figcaption><b>", page->out);
    hl_page_text(page, hl_json_text_of(p, "title"));
    fputs(".</b> ", page->out);
    hl_page_text(page, hl_json_text_of(p, "alt"));
    fputs("</figcaption></figure>\n", page->out);
    return true;
  }
  return false;
}

void hl_page_no_pictures(hl_page *page, const char *command)
{
  if (page->evidence)
    return;
  fputs("<p class=\"quiet\">", page->out);
  hl_page_printf(page, "The folder holds no evidence.json, and so no pictures; %s writes it.",
                 command);
  fputs("</p>\n", page->out);
}

/* ---- documents */

double hl_json_double(const json_t *object, const char *member)
{
  const json_t *value = json_object_get(object, member);
  return json_is_number(value) ? json_number_value(value) : NAN;
}

const char *hl_json_text_of(const json_t *object, const char *member)
{
  const char *text = json_string_value(json_object_get(object, member));
  return text ? text : "";
}

void hl_json_doubles(const json_t *object, const char *member, int n, double *out)
{
  const json_t *list = json_object_get(object, member);
  for (int i = 0; i < n; i++) {
    const json_t *value = json_array_get(list, (size_t)i);
    out[i] = json_is_number(value) ? json_number_value(value) : NAN;
  }
}

bool hl_json_is_true(const json_t *object, const char *member)
{
  return json_is_true(json_object_get(object, member));
}

const char *hl_figure(double value, char text[32])
{
  if (isfinite(value))
    snprintf(text, 32, "%.4g", value);
  else
    snprintf(text, 32, "not stated");
  return text;
}
