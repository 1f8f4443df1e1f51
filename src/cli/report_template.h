/* The files of src/cli/report/ as texts; CMake writes the source. */
#ifndef HL_CLI_REPORT_TEMPLATE_H
#define HL_CLI_REPORT_TEMPLATE_H

extern const char hl_report_html[];
extern const char hl_report_css[];
extern const char hl_report_js[];

#endif
