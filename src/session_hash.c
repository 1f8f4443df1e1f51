/* SHA-256 of a file, by libmd. */
#include <errno.h>
#include <sha2.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include "halflight/session.h"

enum { CHUNK = 1 << 15 };

hl_status hl_file_sha256(hl_ctx *ctx, const char *path, char out[65])
{
  static const char digits[] = "0123456789abcdef";
  FILE *file = fopen(path, "rb");
  if (!file)
    return hl_fail(ctx, HL_ERR_IO, "%s: cannot open: %s", path, strerror(errno));
  SHA2_CTX sum;
  uint8_t bytes[CHUNK];
  uint8_t digest[SHA256_DIGEST_LENGTH];
  SHA256Init(&sum);
  for (size_t n = 0; (n = fread(bytes, 1, sizeof bytes, file)) > 0;)
    SHA256Update(&sum, bytes, n);
  const int error = ferror(file) ? errno : 0;
  fclose(file);
  if (error)
    return hl_fail(ctx, HL_ERR_IO, "%s: cannot read: %s", path, strerror(error));
  SHA256Final(digest, &sum);
  for (int i = 0; i < SHA256_DIGEST_LENGTH; i++) {
    out[2 * i] = digits[digest[i] >> 4];
    out[2 * i + 1] = digits[digest[i] & 15];
  }
  out[64] = '\0';
  return HL_OK;
}
