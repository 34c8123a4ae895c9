// See recording_source.h.
#include "clients/web/gateway/recording_source.h"

#include <boost/asio/post.hpp>
#include <chrono>
#include <exception>
#include <utility>

#include "clients/library/client.h"
#include "proto/wire/request_result.h"

namespace hapticd::web {
namespace {

/// Step of a recording that plays; every tenth is reported.
constexpr std::chrono::milliseconds kPlaybackStep{10};
constexpr int kStepsPerPlayback = 10;

}  // namespace

RecordingSource::RecordingSource(boost::asio::io_context& context, Hub& hub, RecordingFolder folder,
                                 std::function<void(const v1::State&)> shown)
    : context_(context),
      hub_(hub),
      folder_(std::move(folder)),
      shown_(std::move(shown)),
      timer_(context) {}

RecordingSource::~RecordingSource() {
  if (opener_.joinable()) opener_.join();
}

PlaybackHandlers RecordingSource::handlers() {
  PlaybackHandlers made;
  made.state = [this](const v1::State& state) {
    if (shown_) shown_(state);
    hub_.recorded_state(state);
  };
  made.item = [this](const v1::Item& item) { hub_.recorded_item(item); };
  return made;
}

void RecordingSource::open(const std::filesystem::path& file) {
  begin(file.filename().string(), std::make_unique<Playback>(file, handlers()));
}

void RecordingSource::show(const std::string& name, Answer done) {
  if (opener_.joinable()) {
    done(wire::result_of(v1::RESULT_CODE_BUSY, "", "another recording is being opened. Try again"));
    return;
  }
  if (name.empty()) {
    stop();
    playback_.reset();
    hub_.show(daemon_shown());
    done(wire::result_of(v1::RESULT_CODE_OK));
    return;
  }
  auto opening = std::make_shared<Opening>();
  v1::Result found = folder_.find(name, opening->file);
  if (found.code() != v1::RESULT_CODE_OK) {
    done(found);
    return;
  }
  opening->done = std::move(done);
  opener_ = std::thread([this, opening, told = handlers()] {
    try {
      opening->playback = std::make_unique<Playback>(opening->file, told);
    } catch (const std::exception& error) {
      opening->failure = error.what();
    }
    boost::asio::post(context_, [this, opening] { opened(*opening); });
  });
}

void RecordingSource::opened(Opening& opening) {
  opener_.join();
  if (opening.playback == nullptr) {
    opening.done(wire::result_of(v1::RESULT_CODE_FAILED, "", opening.failure));
    return;
  }
  begin(opening.file.filename().string(), std::move(opening.playback));
  opening.done(wire::result_of(v1::RESULT_CODE_OK));
}

void RecordingSource::begin(const std::string& name, std::unique_ptr<Playback> playback) {
  stop();
  playback_ = std::move(playback);
  v1::PageShown shown;
  shown.set_source(v1::PAGE_SOURCE_RECORDING);
  shown.set_recording(name);
  shown.set_cut_off(!playback_->whole());
  shown.set_tools_only(playback_->tools_only());
  hub_.show(shown);
  playback_->begin();
  hub_.playback(playback_->position());
  played_ns_ = 0;
  play();
}

void RecordingSource::play() {
  const std::int64_t now_ns = client::monotonic_now_ns();
  if (played_ns_ != 0) playback_->advance(static_cast<double>(now_ns - played_ns_) * 1e-9);
  played_ns_ = now_ns;
  if (++steps_ >= kStepsPerPlayback) {
    steps_ = 0;
    hub_.playback(playback_->position());
  }
  timer_.expires_after(kPlaybackStep);
  timer_.async_wait([this](const boost::system::error_code& cancelled) {
    // A wait that was over when it was cancelled says nothing of it.
    if (!cancelled && playback_ != nullptr) play();
  });
}

void RecordingSource::steer(const v1::PagePlayback& wanted) {
  if (playback_ == nullptr) return;
  playback_->steer(wanted);
  hub_.playback(playback_->position());
}

std::optional<std::int64_t> RecordingSource::shown_t_ns() const {
  if (playback_ == nullptr) return std::nullopt;
  return playback_->shown_t_ns();
}

void RecordingSource::stop() { timer_.cancel(); }

}  // namespace hapticd::web
