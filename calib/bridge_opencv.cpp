/*
 * OpenCV's decoders and its PNG encoder, behind plain C functions; no exception leaves this file.
 *
 * The codecs below OpenCV print their complaints on standard error and then fill what is missing
 * with grey. Both are caught: standard error is held back while they decode, and for a JPEG, whose
 * decoder has no other way to say so, any complaint is a refusal.
 */
#include "halflight/bridge_opencv.h"

#include <cstdlib>
#include <cstring>
#include <exception>
#include <mutex>
#include <string>
#include <vector>

#include <opencv2/core.hpp>
#include <opencv2/core/utils/logger.hpp>
#include <opencv2/imgcodecs.hpp>

#include "hush.h"

namespace
{

const long pixels_max = 1L << 28;

/* Standard error is held back between construction and `taken`. */
class held_stderr
{
public:
  held_stderr() { hl_hush_begin(&hush); }
  held_stderr(const held_stderr &) = delete;
  held_stderr &operator=(const held_stderr &) = delete;
  ~held_stderr()
  {
    if (held)
      hl_hush_end(&hush, nullptr, 0);
  }
  /* The first line that was printed; "" for none. */
  std::string taken()
  {
    char line[160];
    held = false;
    hl_hush_end(&hush, line, sizeof line);
    /* OpenCV's own line names its source and a temporary file, which helps nobody */
    return std::strncmp(line, "imdecode_", 9) == 0 ? "" : line;
  }

private:
  hl_hush hush{};
  bool held = true;
};

int silent(int, const char *, const char *, const char *, int, void *)
{
  return 0;
}

/* Silence that others share meanwhile: what is printed cannot be told apart, and is lost. */
class shared_silence
{
public:
  shared_silence() { hl_hush_share(); }
  shared_silence(const shared_silence &) = delete;
  shared_silence &operator=(const shared_silence &) = delete;
  ~shared_silence() { hl_hush_leave(); }
};

/* For decoders that say by themselves whether they failed; empty: decode again to hear why. */
cv::Mat decode_beside_others(const unsigned char *bytes, size_t n)
{
  shared_silence silence;
  const cv::Mat raw(1, static_cast<int>(n), CV_8U, const_cast<unsigned char *>(bytes));
  try {
    return cv::imdecode(raw, cv::IMREAD_UNCHANGED);
  } catch (const cv::Exception &) {
    return cv::Mat();
  }
}

cv::Mat decode(const unsigned char *bytes, size_t n, std::string &said)
{
  held_stderr held;
  const cv::Mat raw(1, static_cast<int>(n), CV_8U, const_cast<unsigned char *>(bytes));
  cv::Mat image;
  try {
    image = cv::imdecode(raw, cv::IMREAD_UNCHANGED);
  } catch (const cv::Exception &e) {
    said = e.err;
    return cv::Mat();
  }
  said = held.taken();
  return image;
}

template <typename T> void copy_swapped(const cv::Mat &image, T *out)
{
  const int channels = image.channels();
  for (int y = 0; y < image.rows; y++) {
    const T *row = image.ptr<T>(y);
    for (int x = 0; x < image.cols; x++, row += channels, out += channels)
      for (int c = 0; c < channels; c++)
        out[c] = row[c < 3 && channels >= 3 ? 2 - c : c];
  }
}

hl_status hand_over(hl_ctx *ctx, const char *path, const cv::Mat &image, hl_codes *out)
{
  const int depth = image.depth();
  const int bits = depth == CV_8U ? 8 : depth == CV_16U ? 16 : depth == CV_32F ? 32 : 0;
  if (bits == 0)
    return hl_fail(ctx, HL_ERR_FORMAT,
                   "%s: samples of kind %s; 8-bit, 16-bit or 32-bit float ones are read", path,
                   cv::depthToString(depth));
  if (static_cast<long>(image.rows) * image.cols > pixels_max)
    return hl_fail(ctx, HL_ERR_FORMAT, "%s: %d x %d pixels; up to 2^28 are accepted", path,
                   image.cols, image.rows);
  void *codes = std::malloc(image.total() * image.elemSize());
  if (!codes)
    return hl_fail(ctx, HL_ERR_MEMORY, "%s: no memory for %d x %d pixels", path, image.cols,
                   image.rows);
  if (bits == 8)
    copy_swapped(image, static_cast<unsigned char *>(codes));
  else if (bits == 16)
    copy_swapped(image, static_cast<unsigned short *>(codes));
  else
    copy_swapped(image, static_cast<float *>(codes));
  *out = hl_codes{codes, image.cols, image.rows, image.channels(), bits};
  return HL_OK;
}

} // namespace

void hl_opencv_prepare(void)
{
  static std::once_flag once;
  std::call_once(once, [] {
    setenv("OPENCV_IO_ENABLE_OPENEXR", "1", 0);
    cv::utils::logging::setLogLevel(cv::utils::logging::LOG_LEVEL_SILENT);
    cv::redirectError(silent);
  });
}

hl_status hl_opencv_decode(hl_ctx *ctx, const char *path, const char *kind,
                           const unsigned char *bytes, size_t n, hl_codes *out)
{
  try {
    hl_opencv_prepare();
    if (n > 0x7fffffff)
      return hl_fail(ctx, HL_ERR_FORMAT, "%s: %zu bytes; images under 2 GiB are read", path, n);
    std::string said;
    const bool jpeg = bytes[0] == 0xff, png = bytes[0] == 0x89;
    cv::Mat image = png ? decode_beside_others(bytes, n) : cv::Mat();
    if (image.empty())
      image = decode(bytes, n, said);
    if (image.empty() || (jpeg && !said.empty()))
      return hl_fail(ctx, HL_ERR_FORMAT,
                     "%s: %s is damaged or of a kind that OpenCV does not read%s%.120s", path, kind,
                     said.empty() ? "" : ": ", said.c_str());
    return hand_over(ctx, path, image, out);
  } catch (const std::bad_alloc &) {
    return hl_fail(ctx, HL_ERR_MEMORY, "%s: no memory to decode the image", path);
  } catch (const std::exception &e) {
    return hl_fail(ctx, HL_ERR_FORMAT, "%s: OpenCV cannot decode it: %.120s", path, e.what());
  } catch (...) {
    return hl_fail(ctx, HL_ERR_FORMAT, "%s: OpenCV cannot decode it", path);
  }
}

hl_status hl_opencv_png16(hl_ctx *ctx, const char *path, const unsigned short *codes, int width,
                          int height, int channels, unsigned char **bytes, size_t *n)
{
  try {
    hl_opencv_prepare();
    cv::Mat image(height, width, CV_16UC(channels));
    const cv::Mat given(height, width, CV_16UC(channels), const_cast<unsigned short *>(codes));
    copy_swapped(given, image.ptr<unsigned short>());
    std::vector<unsigned char> png;
    if (!cv::imencode(".png", image, png) || png.empty())
      return hl_fail(ctx, HL_ERR_IO, "%s: OpenCV cannot encode it", path);
    auto *copy = static_cast<unsigned char *>(std::malloc(png.size()));
    if (!copy)
      return hl_fail(ctx, HL_ERR_MEMORY, "%s: no memory to encode the image", path);
    std::memcpy(copy, png.data(), png.size());
    *bytes = copy;
    *n = png.size();
    return HL_OK;
  } catch (const std::bad_alloc &) {
    return hl_fail(ctx, HL_ERR_MEMORY, "%s: no memory to encode the image", path);
  } catch (const std::exception &e) {
    return hl_fail(ctx, HL_ERR_IO, "%s: OpenCV cannot encode it: %.120s", path, e.what());
  } catch (...) {
    return hl_fail(ctx, HL_ERR_IO, "%s: OpenCV cannot encode it", path);
  }
}

const char *hl_opencv_version(void)
{
  try {
    static const std::string version = cv::getVersionString();
    return version.c_str();
  } catch (...) {
    return nullptr;
  }
}
