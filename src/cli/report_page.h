/* A page being written: HTML in memory, text escaped, parts in the order they are asked for. */
#ifndef HL_CLI_REPORT_PAGE_H
#define HL_CLI_REPORT_PAGE_H

#include <jansson.h>
#include <stdio.h>

#include "halflight/halflight.h"

typedef struct hl_page {
  FILE *out;
  const json_t *evidence; /* NULL where the folder holds none */
} hl_page;

/* Text with &, <, > and quotes escaped; control characters, which HTML forbids, as U+FFFD. */
void hl_page_text(hl_page *page, const char *text);

/* printf of text that is escaped, at most 1023 bytes of it. */
void hl_page_printf(hl_page *page, const char *format, ...) HL_PRINTF(2, 3);

/* <tag class="style">text</tag>; style may be NULL. */
void hl_page_element(hl_page *page, const char *tag, const char *style, const char *text);

void hl_page_heading(hl_page *page, const char *text);

/* The headline and what follows from it; reasons as hl_json_reasons and hl_json_notes write them. */
void hl_page_verdict(hl_page *page, bool good, const char *headline, const json_t *reasons,
                     const char *advice);

/* A table of two columns: begin, any number of facts, end. */
void hl_page_facts_begin(hl_page *page);
void hl_page_fact(hl_page *page, const char *name, const char *format, ...) HL_PRINTF(3, 4);
void hl_page_facts_end(hl_page *page);

/* A table of many columns that stacks on a phone. Columns after the first `n_words` hold figures. */
void hl_page_table_begin(hl_page *page, const char *const *columns, int n, int n_words);
void hl_page_row_begin(hl_page *page, bool bad, const char *head);
void hl_page_cell(hl_page *page, const char *column, bool figure, const char *format, ...)
    HL_PRINTF(4, 5);
void hl_page_row_end(hl_page *page);
void hl_page_table_end(hl_page *page);

/* Notes as a table under a heading; nothing where there are none. */
void hl_page_notes(hl_page *page, const char *heading, const json_t *notes);

/* The picture of that name with its caption, where the evidence has it. */
bool hl_page_picture(hl_page *page, const char *name);

/* The folder holds no evidence: say so, and which command writes it. */
void hl_page_no_pictures(hl_page *page, const char *command);

/* ---- reading a document whose members may be missing */

/* NAN where the member is no number. */
double hl_json_double(const json_t *object, const char *member);

/* "" where the member is no text. */
const char *hl_json_text_of(const json_t *object, const char *member);

/* The first n numbers of a list; NAN where there is none. */
void hl_json_doubles(const json_t *object, const char *member, int n, double *out);

bool hl_json_is_true(const json_t *object, const char *member);

/* A figure of 4 digits, or "not stated". */
const char *hl_figure(double value, char text[32]);

#endif
