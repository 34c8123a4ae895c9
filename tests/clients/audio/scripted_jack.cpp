// A libjack that does what a test says: as many of its functions as haptic-audio calls, one client,
// blocks on the clock of this machine, no sound card. It stands for servers whose sample rate and
// blocks change while they run, as PipeWire's do; jackd changes its blocks alone. Loaded in place
// of the real one by LD_LIBRARY_PATH. What the audio port plays is written to SCRIPTED_JACK_OUT,
// block by block: rate, frames (int32), begin (int64, us of CLOCK_MONOTONIC), samples (float).
// Lines read from the FIFO SCRIPTED_JACK_ORDERS between two blocks: `rate N`, `block N`, `xrun`,
// `gone`.
#include <fcntl.h>
#include <jack/jack.h>
#include <jack/midiport.h>
#include <unistd.h>

#include <atomic>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <string>
#include <thread>
#include <vector>

namespace {

struct Server {
  std::atomic<jack_nframes_t> rate{48000};
  std::atomic<jack_nframes_t> block{64};
  JackProcessCallback process = nullptr;
  JackXRunCallback xrun = nullptr;
  JackSampleRateCallback rate_changed = nullptr;
  JackBufferSizeCallback block_changed = nullptr;
  JackShutdownCallback gone = nullptr;
  void* self = nullptr;
  std::vector<float> samples;
  std::vector<char> notes;
  std::int64_t begin_ns = 0;
  std::atomic<bool> running{false};
  std::thread thread;
};

Server server;
int audio_port = 0;
int midi_port = 0;

std::int64_t now_ns() {
  timespec now{};
  clock_gettime(CLOCK_MONOTONIC, &now);
  return now.tv_sec * std::int64_t{1'000'000'000} + now.tv_nsec;
}

void obey(const std::string& line) {
  const auto number = static_cast<jack_nframes_t>(
      std::strtoul(line.substr(line.find(' ') + 1).c_str(), nullptr, 10));
  if (line.starts_with("rate ")) {
    server.rate = number;
    if (server.rate_changed != nullptr) server.rate_changed(number, server.self);
  } else if (line.starts_with("block ")) {
    server.block = number;
    if (server.block_changed != nullptr) server.block_changed(number, server.self);
  } else if (line == "xrun" && server.xrun != nullptr) {
    server.xrun(server.self);
  } else if (line == "gone" && server.gone != nullptr) {
    server.gone(server.self);
  }
}

void obey_all(int orders, std::string& pending) {
  char text[256];
  for (ssize_t got = read(orders, text, sizeof text); got > 0;
       got = read(orders, text, sizeof text))
    pending.append(text, static_cast<std::size_t>(got));
  for (std::size_t end = pending.find('\n'); end != std::string::npos; end = pending.find('\n')) {
    obey(pending.substr(0, end));
    pending.erase(0, end + 1);
  }
}

void write_block(std::FILE* out) {
  const std::int32_t head[2] = {static_cast<std::int32_t>(server.rate.load()),
                                static_cast<std::int32_t>(server.samples.size())};
  const std::int64_t begin_us = server.begin_ns / 1000;
  std::fwrite(head, sizeof head, 1, out);
  std::fwrite(&begin_us, sizeof begin_us, 1, out);
  std::fwrite(server.samples.data(), sizeof(float), server.samples.size(), out);
  std::fflush(out);
}

void serve() {
  // NOLINTNEXTLINE(concurrency-mt-unsafe): nothing in this program changes the environment
  const char* const out_path = std::getenv("SCRIPTED_JACK_OUT");
  // NOLINTNEXTLINE(concurrency-mt-unsafe): nothing in this program changes the environment
  const char* const orders_path = std::getenv("SCRIPTED_JACK_ORDERS");
  std::FILE* const out = std::fopen(out_path, "ab");
  const int orders = open(orders_path, O_RDWR | O_NONBLOCK | O_CLOEXEC);
  std::string pending;
  server.begin_ns = now_ns();
  while (server.running) {
    obey_all(orders, pending);
    const jack_nframes_t frames = server.block;
    server.samples.assign(frames, 0.0F);
    server.process(frames, server.self);
    write_block(out);
    server.begin_ns += std::int64_t{1'000'000'000} * frames / server.rate;
    const timespec until{server.begin_ns / 1'000'000'000, server.begin_ns % 1'000'000'000};
    clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr);
  }
  close(orders);
  std::fclose(out);
}

}  // namespace

extern "C" {

void jack_set_error_function(void (* /*told*/)(const char*)) {}
void jack_set_info_function(void (* /*told*/)(const char*)) {}

jack_client_t* jack_client_open(const char* /*name*/, jack_options_t /*options*/,
                                jack_status_t* status, ...) {
  // NOLINTNEXTLINE(concurrency-mt-unsafe): nothing in this program changes the environment
  if (const char* const rate = std::getenv("SCRIPTED_JACK_RATE")) {
    server.rate = static_cast<jack_nframes_t>(std::strtoul(rate, nullptr, 10));
  }
  *status = {};
  std::fputs("scripted jack: a client opens\n", stderr);
  return reinterpret_cast<jack_client_t*>(&server);
}

int jack_client_close(jack_client_t* /*client*/) {
  server.running = false;
  if (server.thread.joinable()) server.thread.join();
  return 0;
}

int jack_activate(jack_client_t* /*client*/) {
  server.running = true;
  server.thread = std::thread(serve);
  return 0;
}

jack_port_t* jack_port_register(jack_client_t* /*client*/, const char* /*name*/, const char* type,
                                unsigned long /*flags*/, unsigned long /*size*/) {
  const bool midi = std::string(type) == JACK_DEFAULT_MIDI_TYPE;
  return reinterpret_cast<jack_port_t*>(midi ? &midi_port : &audio_port);
}

int jack_set_process_callback(jack_client_t* /*client*/, JackProcessCallback callback, void* self) {
  server.process = callback;
  server.self = self;
  return 0;
}
int jack_set_xrun_callback(jack_client_t* /*client*/, JackXRunCallback callback, void* /*self*/) {
  server.xrun = callback;
  return 0;
}
int jack_set_sample_rate_callback(jack_client_t* /*client*/, JackSampleRateCallback callback,
                                  void* /*self*/) {
  server.rate_changed = callback;
  return 0;
}
int jack_set_buffer_size_callback(jack_client_t* /*client*/, JackBufferSizeCallback callback,
                                  void* /*self*/) {
  server.block_changed = callback;
  return 0;
}
void jack_on_shutdown(jack_client_t* /*client*/, JackShutdownCallback callback, void* /*self*/) {
  server.gone = callback;
}

jack_nframes_t jack_get_sample_rate(jack_client_t* /*client*/) { return server.rate; }
jack_nframes_t jack_get_buffer_size(jack_client_t* /*client*/) { return server.block; }
jack_time_t jack_get_time() { return static_cast<jack_time_t>(now_ns() / 1000); }

int jack_get_cycle_times(const jack_client_t* /*client*/, jack_nframes_t* frame, jack_time_t* begin,
                         jack_time_t* next, float* period_us) {
  *frame = 0;
  *begin = static_cast<jack_time_t>(server.begin_ns / 1000);
  *period_us = 1e6F * static_cast<float>(server.block) / static_cast<float>(server.rate);
  *next = *begin + static_cast<jack_time_t>(*period_us);
  return 0;
}

void* jack_port_get_buffer(jack_port_t* port, jack_nframes_t /*frames*/) {
  if (port == reinterpret_cast<jack_port_t*>(&audio_port)) return server.samples.data();
  return server.notes.data();
}

/// Two blocks, as jackd has them.
void jack_port_get_latency_range(jack_port_t* /*port*/, jack_latency_callback_mode_t /*mode*/,
                                 jack_latency_range_t* range) {
  range->min = range->max = 2 * server.block;
}

void jack_midi_clear_buffer(void* /*buffer*/) {}
int jack_midi_event_write(void* /*buffer*/, jack_nframes_t /*frame*/,
                          const jack_midi_data_t* /*data*/, size_t /*size*/) {
  return 0;
}

const char** jack_get_ports(jack_client_t* /*client*/, const char* /*name*/, const char* /*type*/,
                            unsigned long /*flags*/) {
  return nullptr;
}
jack_port_t* jack_port_by_name(jack_client_t* /*client*/, const char* /*name*/) { return nullptr; }
int jack_port_flags(const jack_port_t* /*port*/) { return 0; }
const char* jack_port_name(const jack_port_t* /*port*/) { return "scripted:out"; }
int jack_connect(jack_client_t* /*client*/, const char* /*from*/, const char* /*to*/) { return 0; }
void jack_free(void* /*data*/) {}

}  // extern "C"
