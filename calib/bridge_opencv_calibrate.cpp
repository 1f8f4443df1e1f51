/*
 * OpenCV's calibration and plane pose, behind plain C functions; no exception leaves this file.
 *
 * OpenCV's own words about a failure are kept for the message; what it would print is silenced.
 */
#include "halflight/bridge_opencv_calibrate.h"

#include <cmath>
#include <exception>
#include <mutex>
#include <vector>

#include <opencv2/calib3d.hpp>
#include <opencv2/core.hpp>

namespace
{

/* Far beyond what changes an intrinsic by its own deviation. */
const cv::TermCriteria tight(cv::TermCriteria::COUNT + cv::TermCriteria::EPS, 100, 1e-10);

int silent(int, const char *, const char *, const char *, int, void *)
{
  return 0;
}

void quiet()
{
  static std::once_flag once;
  std::call_once(once, [] { cv::redirectError(silent); });
}

hl_status gave_up(hl_ctx *ctx, const char *what, const cv::Exception &e)
{
  return hl_fail(ctx, HL_ERR_DEGENERATE, "OpenCV's %s gave up: %.160s", what, e.err.c_str());
}

struct sightings {
  std::vector<std::vector<cv::Point3d>> board64;
  std::vector<std::vector<cv::Point2d>> pixel64;
  std::vector<std::vector<cv::Point3f>> board32; /* calibrateCamera takes no others */
  std::vector<std::vector<cv::Point2f>> pixel32;
};

void fill(const hl_opencv_view &view, sightings &s, bool fisheye)
{
  if (fisheye) {
    s.board64.emplace_back();
    s.pixel64.emplace_back();
  } else {
    s.board32.emplace_back();
    s.pixel32.emplace_back();
  }
  for (int i = 0; i < view.n; i++) {
    const double *b = view.board_m[i], *p = view.pixel[i];
    if (fisheye) {
      s.board64.back().emplace_back(b[0], b[1], 0);
      s.pixel64.back().emplace_back(p[0], p[1]);
    } else {
      s.board32.back().emplace_back(static_cast<float>(b[0]), static_cast<float>(b[1]), 0.0f);
      s.pixel32.back().emplace_back(static_cast<float>(p[0]), static_cast<float>(p[1]));
    }
  }
}

void take_pose(const cv::Mat &rotation, const cv::Mat &translation, hl_pose &out)
{
  for (int i = 0; i < 3; i++) {
    out.rotation_rad[i] = rotation.at<double>(i);
    out.translation_m[i] = translation.at<double>(i);
  }
}

bool is_finite(const hl_pose &pose)
{
  for (int i = 0; i < 3; i++)
    if (!std::isfinite(pose.rotation_rad[i]) || !std::isfinite(pose.translation_m[i]))
      return false;
  return true;
}

void solve(const sightings &s, const hl_camera &c, cv::Mat &k, cv::Mat &d,
           std::vector<cv::Mat> &rotations, std::vector<cv::Mat> &translations)
{
  const cv::Size size(c.width, c.height);
  if (c.model == HL_LENS_FISHEYE) {
    const int flags = cv::fisheye::CALIB_RECOMPUTE_EXTRINSIC | cv::fisheye::CALIB_FIX_SKEW;
    cv::fisheye::calibrate(s.board64, s.pixel64, size, k, d, rotations, translations, flags, tight);
    return;
  }
  cv::calibrateCamera(s.board32, s.pixel32, size, k, d, rotations, translations, cv::CALIB_USE_LU,
                      tight);
}

hl_status calibrate(hl_ctx *ctx, const hl_opencv_view *views, int n_views, hl_camera *camera,
                    hl_pose *cam_from_board)
{
  sightings s;
  hl_camera c = *camera;
  for (int i = 0; i < n_views; i++)
    fill(views[i], s, c.model == HL_LENS_FISHEYE);
  cv::Mat k = cv::Mat::eye(3, 3, CV_64F);
  cv::Mat d = cv::Mat::zeros(c.n_distortion, 1, CV_64F);
  std::vector<cv::Mat> rotations, translations;
  solve(s, c, k, d, rotations, translations);
  c.fx = k.at<double>(0, 0);
  c.fy = k.at<double>(1, 1);
  c.cx = k.at<double>(0, 2);
  c.cy = k.at<double>(1, 2);
  bool finite = std::isfinite(c.fx + c.fy + c.cx + c.cy);
  for (int i = 0; i < c.n_distortion; i++) {
    c.distortion[i] = d.at<double>(i);
    finite = finite && std::isfinite(c.distortion[i]);
  }
  std::vector<hl_pose> poses(static_cast<size_t>(n_views));
  for (size_t i = 0; i < poses.size(); i++) {
    take_pose(rotations[i], translations[i], poses[i]);
    finite = finite && is_finite(poses[i]);
  }
  if (!finite)
    return hl_fail(ctx, HL_ERR_DEGENERATE,
                   "OpenCV's calibration ends in numbers that are not finite");
  for (size_t i = 0; i < poses.size(); i++)
    cam_from_board[i] = poses[i];
  *camera = c;
  return HL_OK;
}

} // namespace

hl_status hl_opencv_calibrate(hl_ctx *ctx, const hl_opencv_view *views, int n_views,
                              hl_camera *camera, hl_pose *cam_from_board)
{
  try {
    quiet();
    return calibrate(ctx, views, n_views, camera, cam_from_board);
  } catch (const std::bad_alloc &) {
    return hl_fail(ctx, HL_ERR_MEMORY, "no memory to calibrate from %d views", n_views);
  } catch (const cv::Exception &e) {
    return gave_up(ctx, "calibration", e);
  } catch (const std::exception &e) {
    return hl_fail(ctx, HL_ERR_DEGENERATE, "OpenCV's calibration gave up: %.160s", e.what());
  } catch (...) {
    return hl_fail(ctx, HL_ERR_DEGENERATE, "OpenCV's calibration gave up");
  }
}

hl_status hl_opencv_plane_poses(hl_ctx *ctx, const double (*board_m)[2], const double (*at)[2],
                                int n, hl_pose out[2], int *found)
{
  try {
    quiet();
    std::vector<cv::Point3d> board;
    std::vector<cv::Point2d> image;
    for (int i = 0; i < n; i++) {
      board.emplace_back(board_m[i][0], board_m[i][1], 0);
      image.emplace_back(at[i][0], at[i][1]);
    }
    std::vector<cv::Mat> rotations, translations;
    const int answers = cv::solvePnPGeneric(board, image, cv::Mat::eye(3, 3, CV_64F), cv::noArray(),
                                            rotations, translations, false, cv::SOLVEPNP_IPPE);
    int kept = 0;
    for (int i = 0; i < answers && i < 2; i++) {
      hl_pose pose;
      take_pose(rotations[static_cast<size_t>(i)], translations[static_cast<size_t>(i)], pose);
      if (is_finite(pose))
        out[kept++] = pose;
    }
    if (kept == 0)
      return hl_fail(ctx, HL_ERR_DEGENERATE, "no pose explains these %d corners", n);
    *found = kept;
    return HL_OK;
  } catch (const std::bad_alloc &) {
    return hl_fail(ctx, HL_ERR_MEMORY, "no memory for the pose of %d corners", n);
  } catch (const cv::Exception &e) {
    return gave_up(ctx, "pose of a plane", e);
  } catch (const std::exception &e) {
    return hl_fail(ctx, HL_ERR_DEGENERATE, "OpenCV's pose of a plane gave up: %.160s", e.what());
  } catch (...) {
    return hl_fail(ctx, HL_ERR_DEGENERATE, "OpenCV's pose of a plane gave up");
  }
}
