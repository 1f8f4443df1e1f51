/* Words of the command line: the first byte chooses the verb, zero bytes and line ends part words. */
#include <stdlib.h>
#include <string.h>

#include "commands.h"
#include "readers.h"

enum { WORDS_MAX = 16 };

hl_status fuzz_options(hl_ctx *ctx, const fuzz_input *input)
{
  char *words[WORDS_MAX];
  int n = 0;
  if (input->n < 2)
    return HL_OK;
  const hl_command *command = hl_commands[input->bytes[0] % hl_commands_count];
  char *text = malloc(input->n);
  void *args = calloc(1, command->size);
  if (!text || !args) {
    free(text);
    free(args);
    return HL_OK;
  }
  memcpy(text, input->bytes + 1, input->n);
  for (size_t at = 0; at + 1 < input->n && n < WORDS_MAX; n++) {
    words[n] = text + at;
    while (at + 1 < input->n && text[at] != '\0' && text[at] != '\n')
      at++;
    text[at++] = '\0';
  }
  if (command->defaults)
    command->defaults(args);
  const hl_status st = hl_options_parse(ctx, command, n, words, args);
  hl_options_release(command, args);
  free(args);
  free(text);
  return st;
}
