/* The verbs, in the order in which the help shows them; everything that lists them reads this list. */
#ifndef HL_CLI_COMMANDS_H
#define HL_CLI_COMMANDS_H

#include "options.h"

extern const hl_command hl_command_bench;
extern const hl_command hl_command_brdf;
extern const hl_command hl_command_calibrate;
extern const hl_command hl_command_capture;
extern const hl_command hl_command_convert;
extern const hl_command hl_command_drift;
extern const hl_command hl_command_estimate;
extern const hl_command hl_command_fit;
extern const hl_command hl_command_help;
extern const hl_command hl_command_info;
extern const hl_command hl_command_locate;
extern const hl_command hl_command_position;
extern const hl_command hl_command_relight;
extern const hl_command hl_command_render;
extern const hl_command hl_command_replay;
extern const hl_command hl_command_report;
extern const hl_command hl_command_target;

extern const hl_command *const hl_commands[];
extern const int hl_commands_count;

/* The verb of that name; NULL where there is none. */
const hl_command *hl_commands_find(const char *name);

/* Says that there is no such verb, and which is near. HL_ERR_ARG. */
hl_status hl_commands_unknown(hl_ctx *ctx, const char *name);

#endif
