// Assertions end a process, so each case runs in a child whose messages come back through a pipe.
#include "core/math/assert.h"

#include <doctest/doctest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <csignal>
#include <cstring>
#include <iostream>
#include <string>
#include <thread>

#include "core/math/fixed_vector.h"

namespace {

struct ChildEnd {
  int signal = 0;  // that ended it, 0 if it exited
  std::string stderr_text;
};

/// Runs `body` in a child process with its stderr caught.
ChildEnd run_in_child(void (*body)()) {
  std::array<int, 2> ends{};
  REQUIRE(pipe(ends.data()) == 0);
  std::cout.flush();  // or the child would print what is buffered a second time
  const pid_t child = fork();
  REQUIRE(child >= 0);
  if (child == 0) {
    // The test framework's own handlers must not report the abort.
    std::signal(SIGABRT, SIG_DFL);
    dup2(ends[1], STDERR_FILENO);
    close(ends[0]);
    body();
    _exit(0);
  }
  close(ends[1]);
  ChildEnd result;
  std::array<char, 256> buffer{};
  for (;;) {
    const ssize_t size = read(ends[0], buffer.data(), buffer.size());
    if (size <= 0) break;
    result.stderr_text.append(buffer.data(), static_cast<std::size_t>(size));
  }
  close(ends[0]);
  int status = 0;
  REQUIRE(waitpid(child, &status, 0) == child);
  if (WIFSIGNALED(status)) result.signal = WTERMSIG(status);
  return result;
}

void say(const char* text) noexcept {
  [[maybe_unused]] const auto written = write(STDERR_FILENO, text, std::strlen(text));
}

void report_condition(const char* condition, const char* file, int line) noexcept {
  say(line > 0 && std::strstr(file, "assert_test.cpp") != nullptr ? "handler: " : "wrong place: ");
  say(condition);
}

void fail_again(const char* /*condition*/, const char* /*file*/, int /*line*/) noexcept {
  say("handler ");
  HD_ASSERT(false);
}

std::atomic<bool> second_thread_failing{false};

/// Starts a second thread that fails too, and is slow afterwards.
void outlast_second_thread(const char* /*condition*/, const char* /*file*/, int /*line*/) noexcept {
  say("first ");
  std::thread([] {
    second_thread_failing = true;
    HD_ASSERT(1 + 1 == 3);
  }).detach();
  while (!second_thread_failing) std::this_thread::yield();
  for (int i = 0; i < 10'000; ++i) std::this_thread::yield();
  say("done");
}

}  // namespace

TEST_CASE("an assertion that holds does nothing") {
  const ChildEnd end = run_in_child([] { HD_ASSERT(1 + 1 == 2); });
  CHECK(end.signal == 0);
  CHECK(end.stderr_text.empty());
}

TEST_CASE("a failed assertion names file, line and condition on stderr and aborts") {
  const ChildEnd end = run_in_child([] { HD_ASSERT(1 + 1 == 3); });
  CHECK(end.signal == SIGABRT);
  CHECK(end.stderr_text.find("assert_test.cpp:") != std::string::npos);
  CHECK(end.stderr_text.find(": assertion failed: 1 + 1 == 3\n") != std::string::npos);
}

TEST_CASE("a failed assertion calls the installed handler, then aborts") {
  const ChildEnd end = run_in_child([] {
    hapticd::set_assertion_handler(report_condition);
    HD_ASSERT(1 + 1 == 3);
  });
  CHECK(end.signal == SIGABRT);
  CHECK(end.stderr_text == "handler: 1 + 1 == 3");
}

TEST_CASE("removing the handler brings the message on stderr back") {
  const ChildEnd end = run_in_child([] {
    hapticd::set_assertion_handler(report_condition);
    hapticd::set_assertion_handler(nullptr);
    HD_ASSERT(false);
  });
  CHECK(end.signal == SIGABRT);
  CHECK(end.stderr_text.find("assertion failed: false") != std::string::npos);
}

TEST_CASE("a handler that fails an assertion itself runs only once") {
  const ChildEnd end = run_in_child([] {
    hapticd::set_assertion_handler(fail_again);
    HD_ASSERT(1 + 1 == 3);
  });
  CHECK(end.signal == SIGABRT);
  CHECK(end.stderr_text == "handler ");
}

TEST_CASE("a second thread that fails does not cut the first one's handler short") {
  const ChildEnd end = run_in_child([] {
    hapticd::set_assertion_handler(outlast_second_thread);
    HD_ASSERT(1 + 1 == 3);
  });
  CHECK(end.signal == SIGABRT);
  CHECK(end.stderr_text == "first done");
}

TEST_CASE("an index beyond the size of a fixed vector fails an assertion") {
  const ChildEnd end = run_in_child([] {
    hapticd::FixedVector<int, 4> vector;
    vector.push_back(1);
    vector[1] = 2;
  });
  CHECK(end.signal == SIGABRT);
}
