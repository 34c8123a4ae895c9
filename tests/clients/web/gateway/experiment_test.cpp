// Experiments through a gateway, with a hapticd-lab that is ten lines of shell: who may begin,
// answer and end, who sees the screens, and what is said when it ends early. What hapticd-lab does
// is tested in tests/system/viewer.
#include <doctest/doctest.h>

#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "tests/clients/web/gateway/browser.h"
#include "tests/clients/web/gateway/running_gateway.h"

namespace hapticd::test {
namespace {

namespace fs = std::filesystem;

/// Shows its words, further sockets and what it is told; FIRST finishes it, EQUAL ends it without a
/// word.
constexpr const char* kLab = R"lab(#!/bin/sh
n=1
say() { printf '{"number": "%d", "stage": "%s", "participant": "P1", "trials": 27, "text": "%s"}\n' "$n" "$1" "$2"; n=$((n + 1)); }
say EXPERIMENT_STAGE_INSTRUCT "$* sockets:$(ls -l /proc/$$/fd | grep -v ' [012] ->' | grep -c socket)"
while read -r line; do
  case $line in
    *FIRST*) say EXPERIMENT_STAGE_DONE done; exit 0 ;;
    *EQUAL*) exit 7 ;;
  esac
  say EXPERIMENT_STAGE_TOUCH "$(printf %s "$line" | tr -d '"')"
done
say EXPERIMENT_STAGE_STOPPED interrupted
exit 130
)lab";

/// A folder with such a program, and a gateway that starts it.
struct Place {
  Place() {
    fs::create_directories(folder);
    std::ofstream(folder / "lab") << kLab;
    fs::permissions(folder / "lab", fs::perms::owner_all);
  }
  ~Place() { fs::remove_all(folder); }
  Place(const Place&) = delete;
  Place& operator=(const Place&) = delete;

  [[nodiscard]] web::WebOptions options() const {
    web::WebOptions made = options_for(9);
    made.experiments.program = folder / "lab";
    made.experiments.folder = folder / "all";
    made.experiments.address = "127.0.0.1:9";
    return made;
  }

  fs::path folder =
      fs::temp_directory_path() / ("hapticd-experiment-" + std::to_string(::getpid()));
};

v1::PageRequest begin(const std::string& participant) {
  v1::PageRequest request;
  v1::ExperimentBegin& wanted = *request.mutable_experiment()->mutable_begin();
  wanted.set_participant(participant);
  wanted.set_seed(7);
  return request;
}

v1::PageRequest reply(v1::ExperimentReply given) {
  v1::PageRequest request;
  v1::ExperimentAnswer& answer = *request.mutable_experiment()->mutable_answer();
  answer.set_number(1);
  answer.set_reply(given);
  return request;
}

v1::PageRequest end() {
  v1::PageRequest request;
  request.mutable_experiment()->mutable_end();
  return request;
}

v1::ExperimentScreen screen(Browser& browser, v1::ExperimentStage stage) {
  return browser
      .wait_for([&](const v1::PageEvent& event) {
        return event.has_experiment() && event.experiment().stage() == stage;
      })
      .experiment();
}

TEST_CASE("a page begins an experiment, sees its screens and answers them, others only look") {
  const Place place;
  RunningGateway gateway(place.options());
  Browser page(gateway.port(), gateway.control());
  CHECK(page.ask(begin("P1")).code() == v1::RESULT_CODE_OK);
  const v1::ExperimentScreen first = screen(page, v1::EXPERIMENT_STAGE_INSTRUCT);
  CHECK(first.yours());
  CHECK(first.text() ==
        "experiment --page --address=127.0.0.1:9 --participant=P1 --seed=7 "
        "--output=" +
            (place.folder / "all/P1").string() + " sockets:0");
  Browser other(gateway.port(), gateway.control());
  CHECK_FALSE(screen(other, v1::EXPERIMENT_STAGE_INSTRUCT).yours());
  CHECK(other.ask(reply(v1::EXPERIMENT_REPLY_NEXT)).code() == v1::RESULT_CODE_NOT_OWNER);
  CHECK(other.ask(begin("P2")).code() == v1::RESULT_CODE_BUSY);
  CHECK(page.ask(reply(v1::EXPERIMENT_REPLY_NEXT)).code() == v1::RESULT_CODE_OK);
  CHECK(screen(page, v1::EXPERIMENT_STAGE_TOUCH).text() ==
        "{number:1,reply:EXPERIMENT_REPLY_NEXT}");
  CHECK(page.ask(reply(v1::EXPERIMENT_REPLY_FIRST)).code() == v1::RESULT_CODE_OK);
  CHECK(screen(other, v1::EXPERIMENT_STAGE_DONE).text() == "done");
}

TEST_CASE("the end of the page that began it ends the experiment, and the next page may go on") {
  const Place place;
  RunningGateway gateway(place.options());
  Browser other(gateway.port(), gateway.control());
  {
    Browser page(gateway.port(), gateway.control());
    CHECK(page.ask(begin("P1")).code() == v1::RESULT_CODE_OK);
    screen(page, v1::EXPERIMENT_STAGE_INSTRUCT);
  }
  CHECK(screen(other, v1::EXPERIMENT_STAGE_STOPPED).text() == "interrupted");
  v1::Result result;
  do {  // the last word of a program comes a moment before its end
    result = other.ask(begin("P1"));
  } while (result.code() == v1::RESULT_CODE_BUSY);
  CHECK(result.code() == v1::RESULT_CODE_OK);
  CHECK(screen(other, v1::EXPERIMENT_STAGE_INSTRUCT).yours());
}

TEST_CASE("who may control ends what another page began") {
  const Place place;
  RunningGateway gateway(place.options());
  Browser page(gateway.port(), gateway.control());
  CHECK(page.ask(begin("P1")).code() == v1::RESULT_CODE_OK);
  Browser other(gateway.port(), gateway.control());
  CHECK(other.ask(end()).code() == v1::RESULT_CODE_OK);
  CHECK(screen(page, v1::EXPERIMENT_STAGE_STOPPED).text() == "interrupted");
}

TEST_CASE("a program that ends without a word is said to have ended") {
  const Place place;
  RunningGateway gateway(place.options());
  Browser page(gateway.port(), gateway.control());
  CHECK(page.ask(begin("P1")).code() == v1::RESULT_CODE_OK);
  CHECK(page.ask(reply(v1::EXPERIMENT_REPLY_EQUAL)).code() == v1::RESULT_CODE_OK);
  const v1::ExperimentScreen last = screen(page, v1::EXPERIMENT_STAGE_STOPPED);
  CHECK(last.text().find("exit code 7") != std::string::npos);
  CHECK(last.participant() == "P1");
  CHECK(last.trials() == 27);
}

TEST_CASE("names that are no folder, pages that only look and a missing program are refused") {
  const Place place;
  web::WebOptions options = place.options();
  options.experiments.program = place.folder / "none";
  RunningGateway gateway(options);
  Browser page(gateway.port(), gateway.control());
  for (const char* name : {"", "../P1", "a/b", "-P1", "P 1", "P\xc3\xa9"}) {
    CAPTURE(name);
    const v1::Result result = page.ask(begin(name));
    CHECK(result.code() == v1::RESULT_CODE_INVALID);
    CHECK(result.path() == "experiment.begin.participant");
  }
  CHECK(page.ask(begin(std::string(65, 'p'))).code() == v1::RESULT_CODE_INVALID);
  const v1::Result missing = page.ask(begin("P1"));
  CHECK(missing.code() == v1::RESULT_CODE_FAILED);
  CHECK(missing.message().find("hapticd-lab does not start") == 0);
  CHECK(page.ask(end()).code() == v1::RESULT_CODE_WRONG_STATE);
  Browser looker(gateway.port());
  CHECK(looker.ask(begin("P1")).code() == v1::RESULT_CODE_NOT_PERMITTED);
}

}  // namespace
}  // namespace hapticd::test
