/* info: what this build is. */
#include <jansson.h>
#include <stdlib.h>

#include "commands.h"
#include "halflight/info.h"
#include "options.h"

typedef struct info_args {
  bool json;
} info_args;

static const hl_option options[] = {
    {.name = "json",
     .group = "Output",
     .help = "print a JSON document on stdout and nothing else",
     .offset = offsetof(info_args, json)},
};

static hl_status print_json(hl_ctx *ctx, const hl_feature *features, int n)
{
  json_t *list = json_object();
  for (int i = 0; i < n; i++) /* a null version: not built in */
    json_object_set_new(list, features[i].name,
                        features[i].version ? json_string(features[i].version) : json_null());
  json_t *document = json_pack("{s:s,s:i,s:s,s:o}", "format", "halflight-info", "version", 1,
                               "halflight", hl_version(), "features", list);
  char *text = document ? json_dumps(document, JSON_INDENT(1)) : NULL;
  json_decref(document);
  if (!text)
    return hl_fail(ctx, HL_ERR_MEMORY, "no memory for the document");
  puts(text);
  free(text);
  return HL_OK;
}

static hl_status run(hl_ctx *ctx, const void *args)
{
  const info_args *a = args;
  int n = 0;
  const hl_feature *features = hl_features(&n);
  if (a->json)
    return print_json(ctx, features, n);
  printf("halflight %s\n", hl_version());
  for (int i = 0; i < n; i++) {
    const char *version = features[i].version;
    printf("  %-10s %-12s %s", features[i].name, version ? version : "not built in",
           features[i].gives);
    if (version)
      printf("\n");
    else
      printf(" (%s)\n", features[i].option);
  }
  return HL_OK;
}

const hl_command hl_command_info = {
    .name = "info",
    .sentence = "Print the version, the features and the library versions.",
    .options = options,
    .n_options = sizeof options / sizeof *options,
    .example = "  $ halflight info\n"
               "  halflight 0.1.0\n"
               "    jansson    2.14         cameras, balls and results as JSON\n"
               "  ...",
    .size = sizeof(info_args),
    .run = run,
};
