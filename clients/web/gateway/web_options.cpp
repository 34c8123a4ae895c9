// See web_options.h.
#include "clients/web/gateway/web_options.h"

#include <CLI/CLI.hpp>
#include <cstdio>
#include <cstdlib>
#include <stdexcept>

#include "clients/library/endpoint.h"
#include "clients/library/named_key.h"
#include "clients/library/program.h"
#include "proto/hints/command_line_fault.h"
#include "proto/hints/quantity_option.h"

namespace hapticd::web {
namespace {

namespace fs = std::filesystem;

/// What is given as text, until it is looked at as a whole.
struct Texts {
  client::DaemonChoice daemon;
  std::string listen = "127.0.0.1:8080";
  std::string stop_key;
};

/// Where the installed files are: HAPTICD_DATA, else ../share/hapticd from the program.
fs::path data_folder() {
  // NOLINTNEXTLINE(concurrency-mt-unsafe): nobody changes the environment
  if (const char* given = std::getenv("HAPTICD_DATA")) return given;
  std::error_code unknown;
  return fs::read_symlink("/proc/self/exe", unknown).parent_path().parent_path() / "share" /
         "hapticd";
}

/// What follows `option`; what is left out is that of `otherwise`.
client::Endpoint endpoint_of(const std::string& option, const std::string& text,
                             const client::Endpoint& otherwise, bool zero_port) {
  try {
    return client::parse_endpoint(text, otherwise, zero_port);
  } catch (const std::invalid_argument& error) {
    throw CLI::ValidationError(option, error.what());
  }
}

/// What `read` gives; what it throws begins with the name of the option.
template <typename Read>
auto read_for(const std::string& option, const Read& read) {
  try {
    return read();
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(option + ": " + error.what());
  }
}

/// What is wrong with a folder that is made when it is first written to; nothing: it can be.
std::string folder_problem(const std::string& path) {
  std::error_code unknown;
  const bool other = fs::exists(path, unknown) && !fs::is_directory(path, unknown);
  return other ? path + " is no folder" : "";
}

/// As hapticd-lab reads it.
std::string address_of(const client::Endpoint& place) {
  const bool bare = place.host.find(':') == std::string::npos;
  return (bare ? place.host : "[" + place.host + "]") + ":" + std::to_string(place.port);
}

void add_options(CLI::App& app, Texts& texts, WebOptions& options) {
  app.set_version_flag("--version", "haptic-web " HAPTICD_VERSION);
  client::add_daemon_options(app, texts.daemon);
  app.add_option("--listen", texts.listen, "where browsers connect, ADDR:PORT; port 0: any")
      ->capture_default_str();
  app.add_option("--stop-key", texts.stop_key,
                 "key of the daemon's Stop road (default: stop.key beside the file of --key)")
      ->type_name("FILE");
  auto* certificate = app.add_option("--cert", options.server.certificate,
                                     "certificate in PEM form; browsers then connect by https")
                          ->type_name("FILE");
  auto* private_key =
      app.add_option("--key-file", options.server.private_key, "key of the certificate")
          ->type_name("FILE");
  certificate->needs(private_key);
  private_key->needs(certificate);
  app.add_option("--name", options.server.names,
                 "name of this machine that browsers may use, beside its addresses; repeatable")
      ->type_name("NAME");
  app.add_option("--page", options.server.page, "folder of the page (default: the installed one)")
      ->type_name("DIR")
      ->check([](const std::string& folder) {
        std::error_code unknown;
        const bool there = fs::is_regular_file(fs::path(folder) / "index.html", unknown);
        return there ? "" : "there is no index.html in " + folder;
      });
  app.add_option("--assets", options.assets,
                 "folder of meshes and trees, in addition to the installed ones; repeatable")
      ->type_name("DIR")
      ->check([](const std::string& path) {
        std::error_code unknown;
        return fs::is_directory(path, unknown) ? "" : "there is no folder " + path;
      });
  app.add_option("--replay", options.recording, "plays this recording instead of a daemon")
      ->type_name("FILE");
  app.add_option("--recordings", options.recordings,
                 "folder of recordings that a page with control may show instead (default: where "
                 "this user's hapticd writes them)")
      ->type_name("DIR")
      ->check(folder_problem);
  app.add_option("--experiments", options.experiments.folder,
                 "folder for experiments begun in pages, with one folder per participant "
                 "(default: experiments, beside this user's recordings)")
      ->type_name("DIR")
      ->check(folder_problem);
  hints::takes_unit(
      app.add_option("--rate", options.link.state_rate_hz, "States requested per second"), "Hz")
      ->check(CLI::Range(1.0, 1000.0))
      ->capture_default_str();
  hints::takes_unit(app.add_option("--delay", options.presentation_delay_s,
                                   "delay at which pages present what happened, s"),
                    "s")
      ->check(CLI::Range(0.0, 1.0))
      ->capture_default_str();
  app.add_option("--viewers", options.server.most_viewers, "maximum number of viewers at once")
      ->check(CLI::Range(1, 10000))
      ->capture_default_str();
}

void finish(const Texts& texts, WebOptions& options) {
  const client::Endpoint server =
      endpoint_of("--server", texts.daemon.server, {options.link.host, options.link.port}, false);
  options.link.host = server.host;
  options.link.port = server.port;
  options.experiments.address = address_of(server);
  options.experiments.key = texts.daemon.key_file;
  const client::Endpoint listen =
      endpoint_of("--listen", texts.listen, {options.server.address, options.server.port}, true);
  options.server.address = listen.host;
  options.server.port = listen.port;
  if (options.server.page.empty()) options.server.page = data_folder() / "web";
  options.assets.push_back(data_folder() / "models");
  options.server.most_connections = options.server.most_viewers + 192;
  options.link.key = read_for(
      "--key", [&] { return client::named_key(texts.daemon.key_file, texts.daemon.role); });
  options.stop.host = server.host;
  options.stop.target.session_port = server.port;
  options.stop.target.key = read_for(
      "--stop-key", [&] { return client::named_stop_key(texts.stop_key, texts.daemon.key_file); });
}

}  // namespace

ParsedOptions parse_options(int argc, const char* const* argv) {
  CLI::App app("Shows a running hapticd, or a recording, in browsers.", "haptic-web");
  app.failure_message(hints::failure_message);
  Texts texts;
  ParsedOptions parsed;
  add_options(app, texts, parsed.options);
  try {
    app.parse(argc, argv);
    finish(texts, parsed.options);
  } catch (const CLI::ParseError& error) {
    parsed.exit_code = app.exit(error) == 0 ? 0 : 2;
  } catch (const std::runtime_error& error) {
    std::fprintf(stderr, "haptic-web: %s\n", error.what());
    parsed.exit_code = 1;
  }
  return parsed;
}

}  // namespace hapticd::web
