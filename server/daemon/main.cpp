// hapticd: reads its options, starts the daemon, ends with its exit code. With the word doctor as
// its first argument it examines the machine instead, with export it writes a table of a recording,
// with device list it names what is plugged in.
#include <spdlog/spdlog.h>

#include <csignal>
#include <cstdio>
#include <exception>
#include <new>
#include <string>
#include <string_view>

#include "core/rt/thread_role.h"
#include "proto/wire/prepared_messages.h"
#include "server/confinement/confinement.h"
#include "server/confinement/landlock.h"
#include "server/daemon/commands.h"
#include "server/daemon/daemon.h"
#include "server/daemon/reached_paths.h"
#include "server/service/journal.h"
#include "server/service/unread_log.h"
#include "server/system/doctor.h"

namespace {

hapticd::SignalRequests signal_requests;

void on_signal(int signal) {
  if (signal == SIGHUP) {
    signal_requests.reload.store(true);
  } else {
    signal_requests.end.store(true);
  }
}

int complain(const char* what, int code) {
  if (hapticd::stderr_is_journal()) {
    hapticd::log_entry(spdlog::level::err, what, {{"HAPTICD_EVENT", "refused"}});
  } else {
    std::fprintf(stderr, "hapticd: %s\n", what);
  }
  return code;
}

/// As far as this run was told to, and the kernel has the means: what is not done is said.
void give_up_what_is_not_needed(const hapticd::DaemonOptions& options) {
  const std::string refused = hapticd::begin_confinement();
  if (!refused.empty()) spdlog::warn("{}", refused);
  if (hapticd::confine_thread.load() == nullptr) return;
  const std::string unreached = hapticd::reach_only(hapticd::reached_paths(options));
  if (!unreached.empty()) spdlog::warn("files are not confined: {}", unreached);
  hapticd::begin_role(hapticd::ThreadRole::kStart);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const std::string_view word = argc > 1 ? argv[1] : "";
    if (word == "doctor") return hapticd::run_doctor(argc - 1, argv + 1);
    if (word == "export") return hapticd::run_export(argc - 1, argv + 1);
    if (word == "device") return hapticd::run_device(argc - 1, argv + 1);
    if (hapticd::stderr_is_journal()) {
      hapticd::log_to_journal();
    } else {
      hapticd::log_without_waiting();
    }
    hapticd::wire::prepare_messages();
    hapticd::DaemonOptions options;
    if (!hapticd::read_options(argc, argv, options)) return hapticd::kExitGood;
    const bool check_only = options.check_only;
    if (!check_only) give_up_what_is_not_needed(options);
    hapticd::Daemon daemon(std::move(options));
    if (check_only) return hapticd::kExitGood;
    for (const int signal : {SIGINT, SIGTERM, SIGHUP}) std::signal(signal, on_signal);
    std::signal(SIGPIPE, SIG_IGN);
    return daemon.run(signal_requests);
  } catch (const hapticd::StartError& error) {
    return complain(error.what(), error.exit_code());
  } catch (const std::bad_alloc&) {
    // Nor is there any to say so by the log.
    std::fputs("hapticd: there is not enough memory to go on\n", stderr);
    return hapticd::kExitInput;
  } catch (const std::exception& error) {
    return complain(error.what(), hapticd::kExitInput);
  }
}
