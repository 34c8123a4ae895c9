// Shows recordings to the viewers of a hub, in place of the daemon and as long as they are wanted.
// A recording is opened beside the loop: a long one takes seconds, in which the session with the
// daemon must go on, or its lease would end. One thread, except for opening. Not RT.
#pragma once

#include <boost/asio/io_context.hpp>
#include <boost/asio/steady_timer.hpp>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <thread>

#include "clients/web/gateway/hub.h"
#include "clients/web/gateway/playback.h"
#include "clients/web/gateway/recording_folder.h"

namespace hapticd::web {

class RecordingSource {
 public:
  /// `shown` gets each State of a recording, for the metrics; `hub` and `context` outlive it.
  RecordingSource(boost::asio::io_context& context, Hub& hub, RecordingFolder folder,
                  std::function<void(const v1::State&)> shown);
  ~RecordingSource();
  RecordingSource(const RecordingSource&) = delete;
  RecordingSource& operator=(const RecordingSource&) = delete;

  /// Opens a file and shows it, for a gateway without a daemon. Throws as Playback does.
  void open(const std::filesystem::path& file);
  /// Shows the recording of that name, or with an empty one the daemon. `done` is called once,
  /// perhaps later; where it is refused, all stays as it was.
  void show(const std::string& name, Answer done);
  /// Goes where and plays as `wanted` says, if a recording is shown.
  void steer(const v1::PagePlayback& wanted);
  /// What can be shown.
  [[nodiscard]] v1::Listing list() const { return folder_.list(); }
  /// The daemon's clock of then, ns; nothing: no recording is shown.
  [[nodiscard]] std::optional<std::int64_t> shown_t_ns() const;
  /// Plays no further.
  void stop();

 private:
  struct Opening {
    std::filesystem::path file;
    std::unique_ptr<Playback> playback;
    std::string failure;
    Answer done;
  };

  [[nodiscard]] PlaybackHandlers handlers();
  void opened(Opening& opening);
  void begin(const std::string& name, std::unique_ptr<Playback> playback);
  void play();

  boost::asio::io_context& context_;
  Hub& hub_;
  RecordingFolder folder_;
  std::function<void(const v1::State&)> shown_;
  boost::asio::steady_timer timer_;
  std::unique_ptr<Playback> playback_;
  std::int64_t played_ns_ = 0;
  int steps_ = 0;
  std::thread opener_;  ///< joinable: a recording is being opened
};

}  // namespace hapticd::web
