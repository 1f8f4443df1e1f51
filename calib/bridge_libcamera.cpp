/*
 * libcamera's cameras as capture sources, behind plain C functions; no exception leaves this file.
 *
 * Written for 0.0.3 and for 0.4 and later. From 0.5 exposure and gain are taken from the automatic
 * one by one (ExposureTimeMode, AnalogueGainMode) rather than by AeEnable alone. Later versions take
 * the roles of a configuration, and give the planes of a buffer, as Spans: `auto` and braces fit both.
 */
#include "halflight/bridge_libcamera.h"

#include <array>
#include <chrono>
#include <condition_variable>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <linux/dma-buf.h>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <sys/ioctl.h>
#include <sys/mman.h>
#include <vector>

#include <libcamera/libcamera.h>
#include <libcamera/logging.h>

#include "halflight/capture.h"
#include "raw_frame.h"

namespace lc = libcamera;

#define HL_LIBCAMERA_FROM(minor) (LIBCAMERA_VERSION_MAJOR > 0 || LIBCAMERA_VERSION_MINOR >= (minor))

namespace
{

const double shortest_wait_s = 5; /* for a frame, beside four exposures */

/* Bytes of a buffer's first plane, mapped for as long as the buffer lives. */
class mapping
{
public:
  explicit mapping(const lc::FrameBuffer &buffer)
  {
    const auto &planes = buffer.planes();
    offset = planes[0].offset == lc::FrameBuffer::Plane::kInvalidOffset ? 0 : planes[0].offset;
    n = offset + planes[0].length;
    file = planes[0].fd.get();
    memory = mmap(nullptr, n, PROT_READ, MAP_SHARED, file, 0);
  }
  mapping(const mapping &) = delete;
  mapping &operator=(const mapping &) = delete;
  ~mapping()
  {
    if (good())
      munmap(memory, n);
  }
  bool good() const { return memory != MAP_FAILED; }
  const unsigned char *bytes() const { return static_cast<unsigned char *>(memory) + offset; }
  size_t size() const { return n - offset; }
  /* memory that is no DMA buffer needs none of this, and says so */
  void sync(bool begin) const
  {
    dma_buf_sync request{};
    request.flags = DMA_BUF_SYNC_READ | (begin ? DMA_BUF_SYNC_START : DMA_BUF_SYNC_END);
    ioctl(file, DMA_BUF_IOCTL_SYNC, &request);
  }

private:
  size_t n, offset;
  int file;
  void *memory;
};

struct source {
  lc::CameraManager manager;
  bool manager_runs = false, acquired = false, streams = false;
  std::shared_ptr<lc::Camera> camera;
  std::unique_ptr<lc::CameraConfiguration> configuration;
  std::unique_ptr<lc::FrameBufferAllocator> allocator;
  std::vector<std::unique_ptr<lc::Request>> requests;
  std::map<const lc::FrameBuffer *, std::unique_ptr<mapping>> mapped;
  lc::ControlList controls{lc::controls::controls};
  hl_session_pixels pixels = HL_PIXELS_PROCESSED;
  double exposure_us = 0;
  const hl_raw_format *format = nullptr;
  std::vector<uint16_t> samples, codes;
  std::mutex mutex; /* of the two below, which libcamera's thread fills */
  std::condition_variable arrived;
  std::deque<lc::Request *> done;
  bool gone = false;

  void completed(lc::Request *request)
  {
    const std::lock_guard<std::mutex> guard(mutex);
    done.push_back(request);
    arrived.notify_one();
  }
  void disconnected()
  {
    const std::lock_guard<std::mutex> guard(mutex);
    gone = true;
    arrived.notify_one();
  }
};

template <typename F> hl_status guarded(hl_ctx *ctx, F &&work)
{
  try {
    return work();
  } catch (const std::bad_alloc &) {
    return hl_fail(ctx, HL_ERR_MEMORY, "no memory for the camera");
  } catch (const std::exception &e) {
    return hl_fail(ctx, HL_ERR_IO, "libcamera failed: %.160s", e.what());
  } catch (...) {
    return hl_fail(ctx, HL_ERR_IO, "libcamera failed");
  }
}

hl_capture_camera named(const lc::Camera &camera)
{
  hl_capture_camera out{};
  const auto model = camera.properties().get(lc::properties::Model);
  std::snprintf(out.id, sizeof out.id, "%s", camera.id().c_str());
  if (model)
    std::snprintf(out.model, sizeof out.model, "%s", std::string(*model).c_str());
  return out;
}

hl_status list(hl_ctx *ctx, void *state, hl_capture_camera **cameras, int *n)
{
  return guarded(ctx, [&] {
    const auto all = static_cast<source *>(state)->manager.cameras();
    auto *out = static_cast<hl_capture_camera *>(std::calloc(all.size() + 1, sizeof **cameras));
    if (!out)
      throw std::bad_alloc();
    for (size_t i = 0; i < all.size(); i++)
      out[i] = named(*all[i]);
    *cameras = out;
    *n = static_cast<int>(all.size());
    return HL_OK;
  });
}

hl_status configure(hl_ctx *ctx, source &s, const char *id)
{
  const bool raw = s.pixels != HL_PIXELS_PROCESSED;
  s.configuration =
      s.camera->generateConfiguration({raw ? lc::StreamRole::Raw : lc::StreamRole::StillCapture});
  if (!s.configuration || s.configuration->empty())
    return hl_fail(ctx, HL_ERR_IO, "camera '%.100s' has no %s stream", id,
                   raw ? "raw" : "processed");
  lc::StreamConfiguration &stream = s.configuration->at(0);
  if (!raw)
    stream.pixelFormat = lc::formats::BGR888; /* red first in memory */
  if (s.configuration->validate() == lc::CameraConfiguration::Invalid)
    return hl_fail(ctx, HL_ERR_IO, "camera '%.100s' takes no configuration of its stream", id);
  s.format = hl_raw_format_of(stream.pixelFormat.fourcc(), stream.pixelFormat.modifier());
  if (!s.format || s.format->bayer != raw)
    return hl_fail(ctx, HL_ERR_IO, "camera '%.100s' gives frames as %s; %s are read", id,
                   stream.pixelFormat.toString().c_str(),
                   raw ? "Bayer frames of 8, 10, 12 or 16 bits, words or CSI-2 packed,"
                       : "RGB888 and BGR888");
  if (s.camera->configure(s.configuration.get()) != 0)
    return hl_fail(ctx, HL_ERR_IO, "camera '%.100s' refuses its configuration", id);
  return HL_OK;
}

hl_status open_camera(hl_ctx *ctx, void *state, const char *id, hl_session_pixels *pixels,
                      hl_capture_camera *opened)
{
  return guarded(ctx, [&] {
    source &s = *static_cast<source *>(state);
    const auto all = s.manager.cameras();
    if (all.empty())
      return hl_fail(ctx, HL_ERR_IO, "no camera: libcamera %s finds none on this machine",
                     lc::CameraManager::version().c_str());
    s.camera = id[0] ? s.manager.get(id) : all[0];
    if (!s.camera)
      return hl_fail(ctx, HL_ERR_IO, "no camera '%.100s'; the first of %zu is '%.100s'", id,
                     all.size(), all[0]->id().c_str());
    *opened = named(*s.camera);
    if (s.camera->acquire() != 0)
      return hl_fail(ctx, HL_ERR_IO, "camera '%.100s' is in use by another program", opened->id);
    s.acquired = true;
    if (*pixels == HL_PIXELS_UNSTATED)
      *pixels = HL_PIXELS_PROCESSED;
    s.pixels = *pixels;
    s.camera->requestCompleted.connect(&s, &source::completed);
    s.camera->disconnected.connect(&s, &source::disconnected);
    return configure(ctx, s, opened->id);
  });
}

hl_status lock_settings(hl_ctx *ctx, void *state, const hl_session_locked *locked, unsigned *lacks)
{
  return guarded(ctx, [&] {
    namespace c = lc::controls;
    source &s = *static_cast<source *>(state);
    const auto &known = s.camera->controls();
    const auto has = [&](const lc::ControlId &id) { return known.find(&id) != known.end(); };
    const auto bit = [&](const lc::ControlId &id, unsigned lack) { return has(id) ? 0u : lack; };
    *lacks = bit(c::ExposureTime, HL_LACKS_EXPOSURE) | bit(c::AnalogueGain, HL_LACKS_GAIN) |
             bit(c::ColourGains, HL_LACKS_WHITE_BALANCE) |
             bit(c::FrameDurationLimits, HL_LACKS_FRAME_DURATION) |
             bit(c::LensPosition, HL_LACKS_FOCUS);
    if (has(c::AeEnable))
      s.controls.set(c::AeEnable, false);
#if HL_LIBCAMERA_FROM(5)
    if (has(c::ExposureTimeMode))
      s.controls.set(c::ExposureTimeMode, static_cast<int32_t>(c::ExposureTimeModeManual));
    if (has(c::AnalogueGainMode))
      s.controls.set(c::AnalogueGainMode, static_cast<int32_t>(c::AnalogueGainModeManual));
#endif
    if (has(c::ExposureTime))
      s.controls.set(c::ExposureTime, static_cast<int32_t>(locked->exposure_us));
    if (has(c::AnalogueGain))
      s.controls.set(c::AnalogueGain, static_cast<float>(locked->gain));
    if (has(c::AwbEnable))
      s.controls.set(c::AwbEnable, false);
    const std::array<float, 2> balance = {static_cast<float>(locked->white_balance[0]),
                                          static_cast<float>(locked->white_balance[1])};
    if (has(c::ColourGains) && balance[0] > 0)
      s.controls.set(c::ColourGains, lc::Span<const float, 2>(balance));
    const std::array<int64_t, 2> limits = {static_cast<int64_t>(locked->frame_duration_us),
                                           static_cast<int64_t>(locked->frame_duration_us)};
    if (has(c::FrameDurationLimits) && limits[0] > 0)
      s.controls.set(c::FrameDurationLimits, lc::Span<const int64_t, 2>(limits));
    if (has(c::AfMode))
      s.controls.set(c::AfMode, static_cast<int32_t>(c::AfModeManual));
    if (has(c::LensPosition) && locked->focus_dioptre >= 0)
      s.controls.set(c::LensPosition, static_cast<float>(locked->focus_dioptre));
    s.exposure_us = locked->exposure_us;
    return HL_OK;
  });
}

hl_status start(hl_ctx *ctx, void *state, int /* first */)
{
  return guarded(ctx, [&] {
    source &s = *static_cast<source *>(state);
    lc::Stream *stream = s.configuration->at(0).stream();
    s.allocator = std::make_unique<lc::FrameBufferAllocator>(s.camera);
    if (s.allocator->allocate(stream) < 0)
      return hl_fail(ctx, HL_ERR_IO, "camera '%.100s' gives no buffers", s.camera->id().c_str());
    for (const auto &buffer : s.allocator->buffers(stream)) {
      auto map = std::make_unique<mapping>(*buffer);
      auto request = s.camera->createRequest();
      if (!map->good() || !request || request->addBuffer(stream, buffer.get()) != 0)
        return hl_fail(ctx, HL_ERR_IO, "camera '%.100s': its buffers cannot be mapped",
                       s.camera->id().c_str());
      s.mapped[buffer.get()] = std::move(map);
      s.requests.push_back(std::move(request));
    }
    if (s.camera->start(&s.controls) != 0)
      return hl_fail(ctx, HL_ERR_IO, "camera '%.100s' does not start", s.camera->id().c_str());
    s.streams = true;
    for (const auto &request : s.requests)
      if (s.camera->queueRequest(request.get()) != 0)
        return hl_fail(ctx, HL_ERR_IO, "camera '%.100s' takes no requests", s.camera->id().c_str());
    return HL_OK;
  });
}

void show_metadata(const lc::ControlList &m, hl_capture_frame &out)
{
  namespace c = lc::controls;
  out.shown = hl_session_locked{};
  out.shown.exposure_us = m.get(c::ExposureTime).value_or(0);
  out.shown.gain = m.get(c::AnalogueGain).value_or(0.0f);
  out.shown.frame_duration_us = static_cast<double>(m.get(c::FrameDuration).value_or(0));
  out.shown.focus_dioptre = m.get(c::LensPosition).value_or(-1.0f);
  out.digital_gain = m.get(c::DigitalGain).value_or(0.0f);
  if (const auto gains = m.get(c::ColourGains)) {
    out.shown.white_balance[0] = (*gains)[0];
    out.shown.white_balance[1] = (*gains)[1];
  }
  if (const auto stamp = m.get(c::SensorTimestamp))
    out.timestamp_ns = *stamp;
  out.codes_mean = hl_frame_defaults();
}

hl_status develop(hl_ctx *ctx, source &s, const mapping &map, hl_capture_frame &out)
{
  const lc::StreamConfiguration &stream = s.configuration->at(0);
  const size_t n = size_t{stream.size.width} * stream.size.height;
  s.samples.resize(n);
  s.codes.resize(3 * n);
  map.sync(true);
  const hl_status st =
      hl_raw_develop(ctx, s.format, s.pixels, map.bytes(), map.size(), stream.stride,
                     static_cast<int>(stream.size.width), static_cast<int>(stream.size.height),
                     s.samples.data(), s.codes.data(), &out);
  map.sync(false);
  return st;
}

hl_status next(hl_ctx *ctx, void *state, hl_capture_frame *out)
{
  return guarded(ctx, [&] {
    source &s = *static_cast<source *>(state);
    const std::chrono::duration<double> longest(shortest_wait_s + 4e-6 * s.exposure_us);
    lc::Request *request = nullptr;
    {
      std::unique_lock<std::mutex> guard(s.mutex);
      s.arrived.wait_for(guard, longest, [&] { return s.gone || !s.done.empty(); });
      if (s.gone)
        return hl_fail(ctx, HL_ERR_IO, "camera '%.100s' vanished", s.camera->id().c_str());
      if (s.done.empty())
        return hl_fail(ctx, HL_ERR_IO, "camera '%.100s' gave no frame for %.0f s",
                       s.camera->id().c_str(), longest.count());
      request = s.done.front();
      s.done.pop_front();
    }
    const auto &metadata = request->metadata();
    const lc::FrameBuffer *buffer = request->buffers().begin()->second;
    *out = hl_capture_frame{};
    out->place = -1;
    out->count = buffer->metadata().sequence;
    out->timestamp_ns = static_cast<int64_t>(buffer->metadata().timestamp);
    show_metadata(metadata, *out);
    hl_ctx inner{};
    if (request->status() != lc::Request::RequestComplete ||
        buffer->metadata().status != lc::FrameMetadata::FrameSuccess)
      std::snprintf(out->why, sizeof out->why, "its buffer came back with an error");
    else if (develop(&inner, s, *s.mapped.at(buffer), *out) == HL_OK)
      out->readable = true;
    else
      std::memcpy(out->why, inner.msg, sizeof out->why);
    if (const auto black = metadata.get(lc::controls::SensorBlackLevels); black && s.format->bayer)
      out->codes_mean.black = (*black)[0] / 65535.0;
    request->reuse(lc::Request::ReuseBuffers);
    if (s.camera->queueRequest(request) != 0)
      return hl_fail(ctx, HL_ERR_IO, "camera '%.100s' takes no more requests",
                     s.camera->id().c_str());
    return HL_OK;
  });
}

void stop(void *state)
{
  source &s = *static_cast<source *>(state);
  try {
    if (s.streams)
      s.camera->stop();
  } catch (...) {
  }
  s.streams = false;
}

void close_camera(void *state)
{
  auto *s = static_cast<source *>(state);
  stop(s);
  try {
    s->requests.clear();
    s->mapped.clear();
    s->allocator.reset();
    s->configuration.reset();
    if (s->camera) {
      s->camera->requestCompleted.disconnect(s);
      s->camera->disconnected.disconnect(s);
    }
    if (s->acquired)
      s->camera->release();
    s->camera.reset();
    if (s->manager_runs)
      s->manager.stop();
  } catch (...) {
  }
  delete s;
}

} // namespace

hl_status hl_capture_libcamera(hl_ctx *ctx, hl_capture_source *out)
{
  return guarded(ctx, [&] {
    lc::logSetTarget(lc::LoggingTargetNone); /* it would print on standard error */
    auto s = std::make_unique<source>();
    if (s->manager.start() != 0)
      return hl_fail(ctx, HL_ERR_IO, "libcamera %s does not start",
                     lc::CameraManager::version().c_str());
    s->manager_runs = true;
    *out = hl_capture_source{"libcamera", s.release(), list, open_camera, lock_settings,
                             start,       next,        stop, close_camera};
    return HL_OK;
  });
}

const char *hl_libcamera_version(void)
{
  try {
    return lc::CameraManager::version().c_str();
  } catch (...) {
    return nullptr;
  }
}
