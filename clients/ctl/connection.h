// How hapticctl reaches a daemon: where it is, what to say when nobody answers, and requests that
// end the program with a reason when they are refused. Not RT.
#pragma once

#include <memory>
#include <stdexcept>
#include <string>
#include <utility>

#include "clients/library/client.h"
#include "clients/library/controller.h"
#include "clients/library/endpoint.h"
#include "clients/library/program.h"

namespace hapticd::ctl {

/// Exit codes, besides 0.
inline constexpr int kRefused = 1;      ///< the daemon refused or failed, or a file is bad
inline constexpr int kUsageBad = 2;     ///< the command line makes no sense
inline constexpr int kUnreachable = 3;  ///< no daemon, or it stopped answering

/// Ends the program with an exit code and what() on stderr.
class Failure : public std::runtime_error {
 public:
  Failure(int exit_code, const std::string& message)
      : std::runtime_error(message), exit_code_(exit_code) {}
  [[nodiscard]] int exit_code() const noexcept { return exit_code_; }

 private:
  int exit_code_;
};

/// What the daemon has refused: with --json its Result is told on stdout too.
class Refusal : public Failure {
 public:
  Refusal(v1::Result result, const std::string& message)
      : Failure(kRefused, message), result_(std::move(result)) {}
  [[nodiscard]] const v1::Result& result() const noexcept { return result_; }

 private:
  v1::Result result_;
};

/// What every command knows.
struct GlobalOptions {
  client::DaemonChoice daemon;
  double timeout_s = 5.0;
  std::string take_over;  ///< why the lease is taken from whoever has it; empty: it is not
  bool json = false;
};

/// Where the daemon is; throws Failure(kUsageBad) when --server says no host and port.
[[nodiscard]] client::Endpoint server_of(const GlobalOptions& options);

/// The timeout as the library takes it.
[[nodiscard]] std::chrono::nanoseconds timeout_of(const GlobalOptions& options);

/// A session that has been answered; throws Failure(kUnreachable) that says what to do when there
/// is no daemon. `handlers` hear what happens from the first answer on.
[[nodiscard]] std::unique_ptr<client::Client> connect(const GlobalOptions& options,
                                                      client::ClientHandlers handlers = {});

/// Throws Refusal unless the result is OK, with code, path and message in words; Failure where no
/// daemon has answered.
void require(const v1::Result& result);

/// A request that needs no lease.
v1::Result ask(client::Client& client, const v1::Item& item, const GlobalOptions& options);

/// Takes the lease, makes the request, gives the lease back.
v1::Result control(client::Client& client, const v1::Item& item, const GlobalOptions& options);

/// Throws Failure(kUsageBad) with --json, for a command that answers people alone; `why` says so,
/// such as "watch draws on a terminal".
void refuse_json(const GlobalOptions& options, const std::string& why);

/// Takes the lease; throws Failure that names who has it, unless it is to be taken over.
void acquire(client::Controller& controller, const client::Client& client,
             const GlobalOptions& options);

}  // namespace hapticd::ctl
