// Scenes: built off-thread, lent to the loop, told to everyone; their live parameters, changed at a
// tick and put back where whoever asked for a change has lost the lease before its tick; and the
// configuration read anew. Not RT.
#pragma once

#include <cstdint>
#include <deque>
#include <future>
#include <memory>
#include <optional>
#include <string>

#include "server/daemon/daemon_plan.h"
#include "server/daemon/live_scene.h"
#include "server/daemon/loop_desk.h"
#include "server/recorder/recorder_thread.h"

namespace hapticd {

class SceneDesk {
 public:
  /// All outlive this; `recorder` may be null.
  SceneDesk(DaemonPlan& plan, LoopDesk& loop, ServedClients& clients, RecorderThread* recorder);

  /// What plays first: the configured scene. Throws StartError, or std::runtime_error.
  [[nodiscard]] std::unique_ptr<PlayedScene> first_scene();
  /// A scene of the recording at `path`, which plays next. Throws StartError when it cannot be
  /// played here as it was recorded.
  [[nodiscard]] std::unique_ptr<PlayedScene> recorded_scene(const v1::SceneRecord& record,
                                                            const std::string& path);

  /// The one that plays, or is about to.
  [[nodiscard]] const LiveScene& newest() const { return scenes_.back(); }
  /// The one that clients know of.
  [[nodiscard]] const LiveScene& told() const { return playing(playing_id_); }
  /// That of a tick or an event.
  [[nodiscard]] const LiveScene& playing(std::uint32_t scene_id) const;
  /// No tick of a scene before this one comes any more.
  void forget_before(std::uint32_t scene_id);

  /// `brought` are the files of load.assets.
  [[nodiscard]] Answer load(const RequestId& id, const v1::LoadScene& load, BroughtFiles brought);
  /// GetParameters, SetParameter. Held until the loop knows of every lease that has ended: it gives
  /// their changes back a tick later, and until then they are among what is set.
  [[nodiscard]] Answer parameters(const RequestId& id, const v1::Item& item);
  /// Those that need not wait any longer.
  void carry_out_held();
  /// Nobody waits for the answer any more.
  void abandon(const RequestId& id);

  /// Lets the level of automatic quality follow, from the tick behind `tick` on; false when the
  /// loop has no room.
  bool set_level(int level, std::uint64_t tick);
  /// Tick of the last change of parameters that was asked for; 0: none waits.
  [[nodiscard]] std::uint64_t change_tick() const noexcept { return change_tick_; }

  /// The loop plays another scene, or gives a change back.
  void take(const LoopEvent& event);
  /// Lends the loop what has been built, and builds what a reload waits for.
  void work();
  /// A scene is on its way.
  [[nodiscard]] bool loading() const noexcept { return reload_waits_ || build_ || swapping_; }
  /// Reads the configuration anew; its scene is loaded once no other one is on its way.
  void reload();

 private:
  /// A scene being built off-thread for a request, or for a reload.
  struct SceneBuild {
    std::optional<RequestId> request;
    bool check_only = false;
    std::future<LoadResult> result;
  };
  /// A request for parameters that is held.
  struct HeldRequest {
    RequestId id;
    v1::Item item;
    std::uint64_t lease_ends = 0;  ///< when it came
  };

  LiveScene& begin_playing(std::shared_ptr<const LoadedScene> loaded);
  [[nodiscard]] std::unique_ptr<GesturePlan> first_gesture(const LoadedScene& scene) const;
  [[nodiscard]] Answer build(const std::optional<RequestId>& request, const v1::LoadScene& load,
                             BroughtFiles brought);
  void finish_build();
  void take_build(SceneBuild& build);
  /// `doubts` are told with the answer to the request.
  void swap_to(std::shared_ptr<const LoadedScene> loaded, const std::optional<RequestId>& request,
               std::string doubts);
  void finish_swap(std::uint32_t scene_id);
  void settle_change(std::uint64_t number, bool dropped);
  [[nodiscard]] Answer get_parameters(const v1::GetParameters& get) const;
  [[nodiscard]] Answer set_parameters(const RequestId& id, const v1::SetParameter& set);
  void announce(const LiveScene& scene);
  void announce_change(const SceneSettings& settings, const v1::SetParameter* set);

  DaemonPlan& plan_;
  LoopDesk& loop_;
  ServedClients& clients_;
  RecorderThread* recorder_;
  /// The one that plays; before it the last one, until its ticks are all taken; after it the
  /// next one, until it plays.
  std::deque<LiveScene> scenes_;
  std::uint32_t playing_id_ = 0;  ///< of the one that clients know of; 0: none yet
  std::uint32_t last_scene_id_ = 0;
  std::optional<SceneBuild> build_;
  bool swapping_ = false;      ///< a scene waits for the loop to take it
  bool reload_waits_ = false;  ///< the scene is to be loaded anew, once nothing else is
  std::uint64_t change_tick_ = 0;
  std::deque<HeldRequest> held_;
};

}  // namespace hapticd
