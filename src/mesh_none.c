/* A build without assimp. */
#include "halflight/relight.h"

hl_status hl_mesh_read(hl_ctx *ctx, const char *path, hl_mesh *out)
{
  (void)out;
  return hl_fail(ctx, HL_ERR_UNAVAILABLE,
                 "%s: meshes are not in this build: build with -DHL_WITH_ASSIMP=ON, or give "
                 "--normals",
                 path);
}
