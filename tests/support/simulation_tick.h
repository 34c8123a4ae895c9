// A simulation led from tick to tick by poses of hands, and what each tick gave: the record, and
// what the simulation keeps beside it. The simulation must outlive what is read. Allocates when
// made alone.
#pragma once

#include <memory>
#include <span>

#include "core/simulation/simulation.h"

namespace hapticd::test {

class SimulationTick {
 public:
  /// One tick, with tool k at `hands[k]`. `work`: that it is allowed; 0: no bound.
  void step(Simulation& simulation, std::span<const HandPose> hands,
            std::int64_t work = 0) noexcept {
    begin(simulation);
    tick_->budget.work = static_cast<std::uint64_t>(work);
    for (std::size_t k = 0; k < tick_->tools.size(); ++k) tick_->tools[k].placed = hands[k];
    simulation.step(*tick_);
  }
  /// The same of one tool.
  void step(Simulation& simulation, const HandPose& hand) noexcept { step(simulation, {&hand, 1}); }
  /// A tick in which nothing is rendered.
  void skip(Simulation& simulation) noexcept {
    begin(simulation);
    tick_->strings.clear();
    skipped_ = true;
  }

  [[nodiscard]] const RenderedTool& tool(std::size_t k) const { return simulation_->rendered(k); }
  [[nodiscard]] std::size_t tool_count() const { return simulation_->tool_count(); }
  /// The record as the simulation has written it.
  [[nodiscard]] const Tick& record() const { return *tick_; }
  [[nodiscard]] const auto& strings() const { return tick_->strings; }
  [[nodiscard]] const StringEvents& events() const {
    static const StringEvents none{};
    return skipped_ ? none : simulation_->events();
  }

 private:
  void begin(Simulation& simulation) noexcept {
    simulation_ = &simulation;
    skipped_ = false;
    tick_->tools.clear();
    while (tick_->tools.size() < simulation.tool_count()) static_cast<void>(tick_->tools.append());
  }

  Simulation* simulation_ = nullptr;
  std::unique_ptr<Tick> tick_ = std::make_unique<Tick>();
  bool skipped_ = false;
};

}  // namespace hapticd::test
