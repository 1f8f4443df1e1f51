/*
 * OpenCV's detectors of chessboards and saddles, behind plain C functions; no exception leaves this
 * file.
 *
 * The sector-based detector (Duda, Frese, Accurate Detection and Localization of Checkerboard
 * Corners, 2018) finds boards that are large, blurred or noisy; the older one, by quads, now and then
 * one that the first misses. The older one takes minutes over a large frame full of detail, so it
 * looks at a reduced one, after the first had another try there. The first draws random numbers: it
 * gets the same ones every time.
 */
#include "halflight/bridge_opencv_corners.h"

#include <algorithm>
#include <exception>
#include <new>
#include <vector>

#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>
#include <opencv2/imgproc.hpp>

#include "halflight/bridge_opencv.h"

namespace
{

const double moved_least = 1e-4; /* px, where a saddle is found */
const int rounds = 100;
const int reduced_side = 1600;

/* The thread's generator is the caller's: it is put back. */
class own_random
{
public:
  own_random() : kept(cv::theRNG()) { cv::theRNG() = cv::RNG(1); }
  own_random(const own_random &) = delete;
  own_random &operator=(const own_random &) = delete;
  ~own_random() { cv::theRNG() = kept; }

private:
  cv::RNG kept;
};

cv::Mat view_of(const hl_opencv_bytes *image)
{
  return cv::Mat(image->height, image->width, CV_8U, const_cast<uint8_t *>(image->pixel),
                 static_cast<size_t>(image->stride));
}

/* What OpenCV refuses (an image too small for it) holds no board. */
bool look_by_sectors(const cv::Mat &image, cv::Size size, std::vector<cv::Point2f> &found)
{
  try {
    return cv::findChessboardCornersSB(image, size, found, cv::CALIB_CB_NORMALIZE_IMAGE);
  } catch (const cv::Exception &) {
    return false;
  }
}

bool look_by_quads(const cv::Mat &image, cv::Size size, std::vector<cv::Point2f> &found)
{
  try {
    return cv::findChessboardCorners(image, size, found,
                                     cv::CALIB_CB_ADAPTIVE_THRESH | cv::CALIB_CB_NORMALIZE_IMAGE |
                                         cv::CALIB_CB_FAST_CHECK);
  } catch (const cv::Exception &) {
    return false;
  }
}

bool look(const cv::Mat &image, cv::Size size, std::vector<cv::Point2f> &found)
{
  if (look_by_sectors(image, size, found))
    return true;
  const int longer = std::max(image.cols, image.rows);
  if (longer <= reduced_side)
    return look_by_quads(image, size, found);
  cv::Mat reduced;
  const double scale = static_cast<double>(reduced_side) / longer;
  cv::resize(image, reduced, cv::Size(), scale, scale, cv::INTER_AREA);
  if (!look_by_sectors(reduced, size, found) && !look_by_quads(reduced, size, found))
    return false;
  const double x = static_cast<double>(image.cols) / reduced.cols;
  const double y = static_cast<double>(image.rows) / reduced.rows;
  for (cv::Point2f &p : found)
    p = cv::Point2f(static_cast<float>((static_cast<double>(p.x) + 0.5) * x - 0.5),
                    static_cast<float>((static_cast<double>(p.y) + 0.5) * y - 0.5));
  return true;
}

/* Stays to the last bit where nothing is found. */
void refine(const cv::Mat &image, int half, double at[2])
{
  const cv::Point2f start(static_cast<float>(at[0]), static_cast<float>(at[1]));
  std::vector<cv::Point2f> point = {start};
  cv::cornerSubPix(
      image, point, cv::Size(half, half), cv::Size(-1, -1),
      cv::TermCriteria(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, rounds, moved_least));
  if (point[0] == start)
    return;
  at[0] = static_cast<double>(point[0].x);
  at[1] = static_cast<double>(point[0].y);
}

} // namespace

hl_status hl_opencv_chessboard(hl_ctx *ctx, const hl_opencv_bytes *image, int columns, int rows,
                               double (*corner)[2], bool *found)
{
  try {
    hl_opencv_prepare();
    const own_random random;
    std::vector<cv::Point2f> points;
    const size_t n = static_cast<size_t>(columns) * static_cast<size_t>(rows);
    *found = look(view_of(image), cv::Size(columns, rows), points) && points.size() == n;
    for (size_t i = 0; *found && i < n; i++) {
      corner[i][0] = static_cast<double>(points[i].x);
      corner[i][1] = static_cast<double>(points[i].y);
    }
    return HL_OK;
  } catch (const std::exception &e) {
    return hl_fail(ctx, HL_ERR_MEMORY, "OpenCV cannot look for a chessboard: %.120s", e.what());
  } catch (...) {
    return hl_fail(ctx, HL_ERR_MEMORY, "OpenCV cannot look for a chessboard");
  }
}

hl_status hl_opencv_chessboard_size(hl_ctx *ctx, const hl_opencv_bytes *image, int *columns,
                                    int *rows)
{
  try {
    hl_opencv_prepare();
    const own_random random;
    std::vector<cv::Point2f> points;
    cv::Mat meta;
    bool found = false;
    try {
      found = cv::findChessboardCornersSB(view_of(image), cv::Size(3, 3), points,
                                          cv::CALIB_CB_NORMALIZE_IMAGE | cv::CALIB_CB_LARGER, meta);
    } catch (const cv::Exception &) {
      found = false;
    }
    *columns = found ? meta.cols : 0;
    *rows = found ? meta.rows : 0;
    return HL_OK;
  } catch (const std::exception &e) {
    return hl_fail(ctx, HL_ERR_MEMORY, "OpenCV cannot look for a chessboard: %.120s", e.what());
  } catch (...) {
    return hl_fail(ctx, HL_ERR_MEMORY, "OpenCV cannot look for a chessboard");
  }
}

hl_status hl_opencv_saddles(hl_ctx *ctx, const float *linear, int width, int height,
                            const int *half, double (*corner)[2], int n)
{
  try {
    hl_opencv_prepare();
    const cv::Mat image(height, width, CV_32F, const_cast<float *>(linear));
    for (int i = 0; i < n; i++) {
      /* OpenCV wants an image larger than the window */
      if (width >= 2 * half[i] + 5 && height >= 2 * half[i] + 5)
        refine(image, half[i], corner[i]);
    }
    return HL_OK;
  } catch (const std::exception &e) {
    return hl_fail(ctx, HL_ERR_MEMORY, "OpenCV cannot refine the corners: %.120s", e.what());
  } catch (...) {
    return hl_fail(ctx, HL_ERR_MEMORY, "OpenCV cannot refine the corners");
  }
}

bool hl_opencv_has_saddles(void)
{
  return true;
}
