// What programs that follow a daemon have in common: where it is, on the command line; the client
// of it; the end by a signal; exit codes. Not RT.
#pragma once

#include <CLI/App.hpp>
#include <functional>
#include <memory>
#include <string>

#include "clients/library/client.h"
#include "clients/library/patience.h"

namespace hapticd::client {

/// Exit codes beside 0.
inline constexpr int kProgramFailed = 1;  ///< a key, an address or a file is bad
inline constexpr int kProgramUsage = 2;   ///< the command line makes no sense

/// The daemon that a command line names.
struct DaemonChoice {
  std::string server = "127.0.0.1:47800";  ///< HOST:PORT, as parse_endpoint() reads it
  std::string key_file;                    ///< empty: the daemon has no keys
  std::string role;                        ///< view or control; empty: by the name of the file
};

/// Refuses on the command line, by the name of `option`, what parse_endpoint() does not read.
/// Returns `option`.
CLI::Option* takes_endpoint(CLI::Option* option);

/// Adds --server, --key and --role. `daemon` must outlive the parsing.
void add_daemon_options(CLI::App& app, DaemonChoice& daemon);

/// A client of that daemon, which need not be there yet. Throws std::invalid_argument where an
/// option makes no sense, and as Client's constructor and read_client_key() do.
[[nodiscard]] std::unique_ptr<Client> open_client(const DaemonChoice& daemon,
                                                  ClientHandlers handlers);

/// What to say to a person when nobody answers at `server`, while the program waits.
[[nodiscard]] std::string unanswered(const std::string& server);

/// Says so on stderr when `patience` with `client` ends, in the name of `program`. To be called
/// again and again.
void tell_silence(const char* program, const Client& client, Patience& patience);

/// Subscribe.divisor for `rate_hz` (> 0) States a second, as nearly as whole ticks allow, where a
/// second has `tick_rate_hz` ticks, as a server says: it may be any number.
[[nodiscard]] std::uint32_t state_divisor(double tick_rate_hz, double rate_hz);

/// Asks for `rate_hz` States a second; for none where it is 0.
void set_rate(double tick_rate_hz, double rate_hz, v1::Subscribe& subscribe);

/// SIGINT and SIGTERM do not end the program from now on, but make has_ended() true.
void end_on_signals();
[[nodiscard]] bool has_ended() noexcept;

/// A program that follows a daemon.
struct Program {
  const char* name;
  const char* purpose;  ///< a sentence, for its --help
  /// Adds its options to the command line, and returns what runs once they are read.
  std::function<int()> (*prepare)(CLI::App& app);
};

/// Reads the command line and runs the program. Returns its exit code, or that of what went wrong,
/// which is said on stderr.
[[nodiscard]] int run_program(const Program& program, int argc, char** argv) noexcept;

}  // namespace hapticd::client
