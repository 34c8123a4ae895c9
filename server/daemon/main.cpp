// hapticd: reads its options, starts the daemon, ends with its exit code. With the word doctor as
// its first argument it examines the machine instead, with export it writes a table of a recording,
// with device list it names what is plugged in.
#include <csignal>
#include <cstdio>
#include <exception>
#include <string_view>

#include "server/daemon/commands.h"
#include "server/daemon/daemon.h"
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
    hapticd::DaemonOptions options;
    if (!hapticd::read_options(argc, argv, options)) return hapticd::kExitGood;
    const bool check_only = options.check_only;
    hapticd::Daemon daemon(std::move(options));
    if (check_only) return hapticd::kExitGood;
    for (const int signal : {SIGINT, SIGTERM, SIGHUP}) std::signal(signal, on_signal);
    std::signal(SIGPIPE, SIG_IGN);
    return daemon.run(signal_requests);
  } catch (const hapticd::StartError& error) {
    return complain(error.what(), error.exit_code());
  } catch (const std::exception& error) {
    return complain(error.what(), hapticd::kExitInput);
  }
}
