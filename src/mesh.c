/* Triangle meshes, read by assimp. */
#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

#include <assimp/cimport.h>
#include <assimp/config.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>

#include "halflight/relight.h"
#include "halflight/vec3.h"

static const float smooth_below_deg = 60; /* sharper edges stay edges */

static hl_status mesh_new(hl_ctx *ctx, const char *path, size_t vertices, size_t faces,
                          hl_mesh *out)
{
  if (vertices > (size_t)1 << 28 || faces > (size_t)1 << 28) {
    hl_fail(ctx, HL_ERR_FORMAT, "%s: %zu faces; up to 2^28 are accepted", path, faces);
    return HL_ERR_FORMAT;
  }
  hl_mesh m = {.position = malloc(vertices * 3 * sizeof(double)),
               .normal = malloc(vertices * 3 * sizeof(double)),
               .face = malloc(faces * 3 * sizeof(int))};
  *out = m;
  if (m.position && m.normal && m.face)
    return HL_OK;
  hl_mesh_free(out);
  hl_fail(ctx, HL_ERR_MEMORY, "%s: no memory for %zu faces", path, faces);
  return HL_ERR_MEMORY;
}

static void count(const struct aiScene *scene, size_t *vertices, size_t *faces)
{
  *vertices = *faces = 0;
  for (unsigned i = 0; i < scene->mNumMeshes; i++) {
    const struct aiMesh *part = scene->mMeshes[i];
    *vertices += part->mNumVertices;
    for (unsigned k = 0; k < part->mNumFaces; k++)
      *faces += part->mFaces[k].mNumIndices == 3;
  }
}

/* Append one part; the scene's transforms are in its vertices already. */
static hl_status append(hl_ctx *ctx, const char *path, const struct aiMesh *part, hl_mesh *out)
{
  const int first = out->n_vertices;
  for (unsigned i = 0; i < part->mNumVertices; i++) {
    const struct aiVector3D p = part->mVertices[i];
    const struct aiVector3D zero = {0, 0, 0}, n = part->mNormals ? part->mNormals[i] : zero;
    const double position[3] = {(double)p.x, (double)p.y, (double)p.z};
    const double normal[3] = {(double)n.x, (double)n.y, (double)n.z};
    const size_t at = 3 * (size_t)out->n_vertices++;
    for (int k = 0; k < 3; k++)
      if (!isfinite(position[k]) || !isfinite(normal[k]))
        return hl_fail(ctx, HL_ERR_FORMAT, "%s: vertex %u is (%g, %g, %g); finite ones are needed",
                       path, i + 1, position[0], position[1], position[2]);
    memcpy(out->position + at, position, sizeof position);
    hl_unit(normal, out->normal + at);
  }
  for (unsigned k = 0; k < part->mNumFaces; k++) {
    const struct aiFace *face = &part->mFaces[k];
    if (face->mNumIndices != 3)
      continue;
    for (int i = 0; i < 3; i++)
      out->face[3 * (size_t)out->n_faces + (size_t)i] = first + (int)face->mIndices[i];
    out->n_faces++;
  }
  return HL_OK;
}

hl_status hl_mesh_read(hl_ctx *ctx, const char *path, hl_mesh *out)
{
  if (access(path, R_OK) != 0)
    return hl_fail(ctx, HL_ERR_IO, "%s: cannot open: %s", path, strerror(errno));
  struct aiPropertyStore *settings = aiCreatePropertyStore();
  if (!settings)
    return hl_fail(ctx, HL_ERR_MEMORY, "%s: no memory to read it", path);
  aiSetImportPropertyFloat(settings, AI_CONFIG_PP_GSN_MAX_SMOOTHING_ANGLE, smooth_below_deg);
  const struct aiScene *scene =
      aiImportFileExWithProperties(path,
                                   aiProcess_Triangulate | aiProcess_PreTransformVertices |
                                       aiProcess_GenSmoothNormals | aiProcess_SortByPType,
                                   NULL, settings);
  aiReleasePropertyStore(settings);
  if (!scene) {
    const char *said = aiGetErrorString();
    const size_t length = strlen(said);
    const int shown = (int)(length > 0 && said[length - 1] == '.' ? length - 1 : length);
    return hl_fail(ctx, HL_ERR_FORMAT, "%s: it cannot be read as a mesh with faces: %.*s", path,
                   shown < 160 ? shown : 160, said);
  }
  size_t vertices, faces;
  hl_mesh mesh = {0};
  count(scene, &vertices, &faces);
  hl_status st = faces > 0 ? mesh_new(ctx, path, vertices, faces, &mesh) : HL_ERR_FORMAT;
  if (faces == 0)
    hl_fail(ctx, st, "%s: a mesh without a face; triangles are needed", path);
  for (unsigned i = 0; st == HL_OK && i < scene->mNumMeshes; i++)
    st = append(ctx, path, scene->mMeshes[i], &mesh);
  aiReleaseImport(scene);
  if (st == HL_OK)
    *out = mesh;
  else
    hl_mesh_free(&mesh);
  return st;
}
