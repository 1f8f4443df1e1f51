/* The kinds of report, one for each document that a verb writes. */
#ifndef HL_CLI_REPORT_H
#define HL_CLI_REPORT_H

#include "evidence.h"
#include "report_page.h"

/* What a report is made from. */
typedef struct hl_report_source {
  const char *folder;
  const char *path;       /* of the document, for messages */
  const json_t *document; /* its format and version have been checked */
  hl_evidence *drawn;     /* for charts that the report draws itself */
} hl_report_source;

/* Write the page's body, heading first. HL_ERR_FORMAT where the document lacks what its kind must have;
 * HL_ERR_IO, HL_ERR_MEMORY. */
typedef hl_status hl_report_write(hl_ctx *ctx, const hl_report_source *source, hl_page *page);

hl_report_write hl_report_bench;
hl_report_write hl_report_calibration;
hl_report_write hl_report_drift;
hl_report_write hl_report_fit;
hl_report_write hl_report_frame;
hl_report_write hl_report_session;

#endif
