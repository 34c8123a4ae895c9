// See options.h.
#include "clients/audio/options.h"

#include <CLI/CLI.hpp>

#include "proto/hints/quantity_option.h"

namespace hapticd::audio {
namespace {

void add_playing(CLI::App& app, Options& options) {
  client::add_daemon_options(app, options.daemon);
  hints::takes_unit(
      app.add_option("--delay-ms", options.delay_ms,
                     "from an event to its sound (default: 8, or what the sound card needs)"),
      "ms")
      ->check(CLI::Range(0.0, 1000.0));
  hints::takes_unit(app.add_option("--gain-db", options.gain_db, "louder or softer"), "dB")
      ->check(CLI::Range(-80.0, 40.0))
      ->capture_default_str();
  auto* const tones =
      app.add_option("--tones", options.tones,
                     "folder with a recorded tone per string (default: those that are shipped)")
          ->type_name("DIR");
  app.add_flag("--synth", options.synth, "compute the strings, play no recordings")
      ->excludes(tones);
  auto* const list = app.add_flag("--list", options.list, "list where sound can go, and exit");
  app.add_flag("--json", options.json, "the list as one JSON object, for programs")->needs(list);
  app.add_option("--connect", options.connect, "port of JACK to play to (default: the sound card)")
      ->type_name("PORT");
  app.add_flag("--no-connect", options.no_connect, "leave the port unconnected");
  app.add_option("--name", options.name, "name of the JACK client")->capture_default_str();
  app.add_flag("--wait", options.wait, "wait for a JACK server instead of ending without one");
  app.add_flag("--verbose", options.verbose, "every ten seconds: tones, lateness, clock");
}

void add_rendering(CLI::App& app, Options& options) {
  auto* const render = app.add_option("--render", options.render,
                                      "write the sound to a .wav or .flac instead of playing it")
                           ->type_name("FILE");
  app.add_option("--recording", options.recording,
                 "render a recording of hapticd (default: the open strings)")
      ->type_name("FILE")
      ->needs(render);
  hints::takes_unit(app.add_option("--rate", options.rate_hz, "sample rate to render at, Hz"), "Hz")
      ->check(CLI::Range(8000.0, 192000.0))
      ->capture_default_str();
  app.add_option("--render-tones", options.render_tones, "write a tone file for each open string")
      ->type_name("DIR");
}

}  // namespace

void add_options(CLI::App& app, Options& options) {
  app.set_version_flag("--version", "haptic-audio " HAPTICD_VERSION);
  add_playing(app, options);
  add_rendering(app, options);
}

}  // namespace hapticd::audio
