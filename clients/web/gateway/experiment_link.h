// The experiment of the paper's Table 1 in a page: hapticd-lab runs it, with its own session
// at the daemon, and writes its files; the desk starts it for one page at a time, hands its screens
// to all and the answers of that page to it. When that page goes, the experiment ends, what was
// answered is kept, and begun again it goes on. One thread. Not RT.
#pragma once

#include <boost/asio/io_context.hpp>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "clients/web/gateway/child_process.h"
#include "clients/web/gateway/page_lease.h"
#include "hapticd/v1/gateway.pb.h"

namespace hapticd::web {

/// How hapticd-lab is started.
struct ExperimentOptions {
  std::filesystem::path program;  ///< empty: the one beside this program, or in PATH
  std::filesystem::path folder;   ///< a folder in it for each participant
  std::string address;            ///< of the daemon, HOST:PORT
  std::filesystem::path key;      ///< file of its key; empty: none
};

/// Takes a screen and the page that may answer it.
using ScreenHandler = std::function<void(const v1::ExperimentScreen&, ViewerId owner)>;

class ExperimentLink {
 public:
  /// `shown` and `context` outlive it.
  ExperimentLink(boost::asio::io_context& context, ExperimentOptions options, ScreenHandler shown);
  ~ExperimentLink();
  ExperimentLink(const ExperimentLink&) = delete;
  ExperimentLink& operator=(const ExperimentLink&) = delete;

  /// What `viewer` asks, with its answer.
  [[nodiscard]] v1::Result take(ViewerId viewer, bool control, const v1::PageExperiment& asked);
  /// The page is gone.
  void gone(ViewerId viewer);
  /// Ends what runs.
  void stop();

 private:
  [[nodiscard]] v1::Result begin(ViewerId viewer, const v1::ExperimentBegin& wanted);
  [[nodiscard]] v1::Result answer(ViewerId viewer, const v1::ExperimentAnswer& answer);
  [[nodiscard]] std::vector<std::string> words(const v1::ExperimentBegin& wanted) const;
  void said(const std::string& line);
  void ended(int exit_code);

  boost::asio::io_context& context_;
  ExperimentOptions options_;
  ScreenHandler shown_;
  std::shared_ptr<ChildProcess> program_;  ///< empty: none runs
  v1::ExperimentScreen screen_;            ///< newest of what runs
  ViewerId owner_ = 0;
};

/// hapticd/experiments in $XDG_STATE_HOME, or in ~/.local/state.
[[nodiscard]] std::filesystem::path default_experiments();

}  // namespace hapticd::web
