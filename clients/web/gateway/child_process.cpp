// See child_process.h.
#include "clients/web/gateway/child_process.h"

#include <spawn.h>
#include <sys/socket.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <boost/asio/buffer.hpp>
#include <boost/asio/read_until.hpp>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <system_error>
#include <utility>

// NOLINTBEGIN(misc-no-recursion): handlers that begin the next step look like recursion.
namespace hapticd::web {

namespace asio = boost::asio;
using boost::system::error_code;

namespace {

/// Longest line it may say, bytes; with a longer one it is ended.
constexpr std::size_t kMaxLineBytes = 1U << 16U;
/// Time that it gets to end after its input has ended: it writes what it has, and says Bye.
constexpr std::chrono::seconds kPatience{10};

[[noreturn]] void fail(int error, const std::string& what) {
  throw std::system_error(error, std::generic_category(), what);
}

/// Starts it with `end` as its standard input and output, and nothing else of ours but standard
/// error: a socket it kept would not close with us.
pid_t spawn(std::vector<std::string>& words, int end) {
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_adddup2(&actions, end, STDIN_FILENO);
  posix_spawn_file_actions_adddup2(&actions, end, STDOUT_FILENO);
  posix_spawn_file_actions_addclosefrom_np(&actions, STDERR_FILENO + 1);
  std::vector<char*> pointers;
  pointers.reserve(words.size() + 1);
  for (std::string& word : words) pointers.push_back(word.data());
  pointers.push_back(nullptr);
  pid_t pid = -1;
  const int error =
      posix_spawnp(&pid, pointers.front(), &actions, nullptr, pointers.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (error != 0) fail(error, words.front());
  return pid;
}

}  // namespace

ChildProcess::ChildProcess(asio::io_context& context, LineHandlers handlers)
    : handlers_(std::move(handlers)), socket_(context), process_(context), patience_(context) {}

void ChildProcess::start(std::vector<std::string> words) {
  std::array<int, 2> ends{};
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends.data()) != 0) {
    fail(errno, "socketpair");
  }
  socket_.assign(asio::local::stream_protocol(), ends[0]);
  socket_.non_blocking(true);
  try {
    pid_ = spawn(words, ends[1]);
  } catch (...) {
    close(ends[1]);
    throw;
  }
  close(ends[1]);
  // glibc 2.36 declares pidfd_open() without extern "C".
  const int process = static_cast<int>(syscall(SYS_pidfd_open, pid_, 0));
  if (process < 0) fail(errno, "pidfd_open");
  process_.assign(process);
  read();
}

void ChildProcess::read() {
  asio::async_read_until(socket_, asio::dynamic_buffer(incoming_, kMaxLineBytes), '\n',
                         [self = shared_from_this()](const error_code& error, std::size_t bytes) {
                           if (error) return self->reap();
                           const std::string line = self->incoming_.substr(0, bytes - 1);
                           self->incoming_.erase(0, bytes);
                           self->handlers_.line(line);
                           self->read();
                         });
}

void ChildProcess::say(std::string_view line) {
  const std::string text = std::string(line) + "\n";
  error_code error;
  if (socket_.send(asio::buffer(text), 0, error) != text.size()) finish();
}

void ChildProcess::finish() {
  error_code gone;
  socket_.shutdown(asio::local::stream_protocol::socket::shutdown_send, gone);
  patience_.expires_after(kPatience);
  patience_.async_wait([self = shared_from_this()](const error_code& cancelled) {
    if (!cancelled && self->pid_ > 0) kill(self->pid_, SIGTERM);
  });
}

void ChildProcess::reap() {
  // It says no more, or too much at once.
  finish();
  process_.async_wait(asio::posix::stream_descriptor::wait_read,
                      [self = shared_from_this()](const error_code& error) {
                        if (!error) self->tell_end();
                      });
}

void ChildProcess::tell_end() {
  int status = 0;
  waitpid(pid_, &status, 0);
  pid_ = -1;
  patience_.cancel();
  handlers_.ended(WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status));
}

std::string program_beside(const std::string& name) {
  std::error_code unknown;
  const std::filesystem::path beside =
      std::filesystem::read_symlink("/proc/self/exe", unknown).parent_path() / name;
  return !unknown && access(beside.c_str(), X_OK) == 0 ? beside.string() : name;
}

}  // namespace hapticd::web
// NOLINTEND(misc-no-recursion)
