/* target: a calibration target, drawn at true scale. */
#include <stdio.h>
#include <stdlib.h>

#include "commands.h"
#include "halflight/target.h"
#include "options.h"
#include "outputs.h"
#include "target_sheet.h"

typedef struct target_args {
  const char *spec, *out;
  hl_sheet_settings sheet_settings;
} target_args;

#define AT(member) offsetof(target_args, member)

static const hl_operand operands[] = {
    {"SPEC", "aprilgrid:COLSxROWS:TAG_M:SPACING_RATIO or chessboard:COLSxROWS:SQUARE_M", AT(spec),
     HL_OPERAND_NEEDED},
};

static const hl_option options[] = {
    {"border-bits", "1|2", "Target", NULL, AT(sheet_settings), hl_sheet_fields, 0},
    {"page", "fit|a4|a3|letter", "Sheet", NULL, AT(sheet_settings), hl_sheet_fields, 0},
    {"dpi", "N", NULL, NULL, AT(sheet_settings), hl_sheet_fields, 0},
    {"out", "FILE", "Output", "write the sheet there: .pdf, .svg or .png; always needed", AT(out),
     0, 0},
};

static void print_summary(const hl_sheet *s)
{
  const hl_target *t = &s->target;
  char spec[HL_TARGET_SPEC_MAX];
  printf("target   %s, %d corners", hl_target_spec(t, spec), hl_target_corners(t));
  if (t->kind == HL_TARGET_APRILGRID)
    printf(", %d-bit border", s->border_bits);
  printf("\ncorners  first to last %.6g mm across, %.6g mm down\n", s->span_mm[0], s->span_mm[1]);
  printf("sheet    %.1f x %.1f mm", s->width_mm, s->height_mm);
  if (s->kind == HL_PICTURE_PNG)
    printf(", %d x %d pixels, %g dpi; edges %s", hl_sheet_pixels(s, s->width_mm),
           hl_sheet_pixels(s, s->height_mm), s->dpi,
           s->whole_pixels ? "on whole pixels" : "within pixels");
  printf("\n");
}

/* Text that stdout does not take leaves no file. */
static hl_status write_and_print(hl_ctx *ctx, hl_outputs *outputs, int at, const hl_sheet *sheet)
{
  hl_status st = hl_outputs_begin(ctx, outputs);
  if (st == HL_OK)
    st = hl_draw_target(ctx, sheet, outputs->stage[at]);
  if (st == HL_OK) {
    print_summary(sheet);
    st = hl_outputs_print(ctx);
  }
  if (st == HL_OK)
    st = hl_outputs_commit(ctx, outputs);
  hl_outputs_end(ctx, outputs);
  return st;
}

static hl_status run(hl_ctx *ctx, const void *args)
{
  const target_args *a = args;
  hl_target target;
  hl_picture_kind kind = HL_PICTURE_PDF;
  hl_sheet sheet;
  int at = 0;
  hl_status st = hl_target_parse(ctx, a->spec, &target);
  if (st == HL_OK && !a->out)
    st = hl_fail(ctx, HL_ERR_ARG, "--out is missing; --out FILE.pdf, .svg or .png is needed");
  if (st == HL_OK)
    st = hl_picture_kind_of(ctx, "out", a->out, &kind);
  if (st == HL_OK)
    st = hl_sheet_plan(ctx, &target, kind, &a->sheet_settings, &sheet);
  if (st != HL_OK)
    return st;
  hl_outputs *outputs = calloc(1, sizeof *outputs);
  if (!outputs)
    return hl_fail(ctx, HL_ERR_MEMORY, "no memory for the run");
  st = hl_outputs_add(ctx, outputs, NULL, a->out, &at);
  if (st == HL_OK)
    st = write_and_print(ctx, outputs, at, &sheet);
  free(outputs);
  return st;
}

const hl_command hl_command_target = {
    .name = "target",
    .sentence = "Draw a calibration target at true scale.",
    .operands = operands,
    .n_operands = sizeof operands / sizeof *operands,
    .options = options,
    .n_options = sizeof options / sizeof *options,
    .notes = "COLS and ROWS count an AprilGrid's tags, which are of family tag36h11, or a\n"
             "chessboard's inner corners. Print at 100 % and measure; where the print is off,\n"
             "calibrate with the size of the tag or square as it was measured.\n"
             "Exit status: 0 done, 1 failed, 2 wrong usage.",
    .example = "  $ halflight target aprilgrid:6x6:0.03:0.3 --page a3 --out target.pdf\n"
               "  target   aprilgrid:6x6:0.03:0.3, 144 corners, 2-bit border\n"
               "  corners  first to last 225 mm across, 225 mm down\n"
               "  sheet    297.0 x 420.0 mm",
    .size = sizeof(target_args),
    .run = run,
};
