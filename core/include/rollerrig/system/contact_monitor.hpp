// system/contact_monitor.hpp - whether the model still holds in its contacts, looked at after each accepted step.
//
//   evaluation at a step's end -> [monitor] -> Status, counters of what was unusual
#pragma once
#include "rollerrig/status.hpp"
#include "rollerrig/system/force_assembly.hpp"

namespace rollerrig {

/// What happened in the contacts of a run, summed over accepted steps.
struct ContactCounters {
  std::int64_t limited_curvature{0};     ///< patches whose curvatures were outside Hertz' theory
  std::int64_t clamped_aspect{0};        ///< patches with a/b outside Kalker's table
  std::int64_t overlapping{0};           ///< pairs of patches of one wheel whose ellipses overlap
  std::int64_t several_patches{0};       ///< wheels with more than one patch
  std::int64_t refined{0};               ///< wheels whose strips had not settled and were solved again, more of them
  std::int64_t faded{0};                 ///< patches that counted in part, contact/normal/hertz_ellipses.hpp
  std::int64_t lost{0};                  ///< wheels without contact
  std::int64_t negative_dissipation{0};  ///< patches whose creep law fed energy in
  std::int64_t checked{0};               ///< wheels looked at

  static constexpr auto fields() {
    using P = ContactCounters;
    return members(Member{"limited_curvature", &P::limited_curvature}, Member{"clamped_aspect", &P::clamped_aspect},
                   Member{"overlapping", &P::overlapping}, Member{"several_patches", &P::several_patches},
                   Member{"refined", &P::refined}, Member{"faded", &P::faded}, Member{"lost", &P::lost},
                   Member{"negative_dissipation", &P::negative_dissipation}, Member{"checked", &P::checked});
  }
  void state(auto& archive) {
    fields()([&](auto const&... count) { archive(this->*count.member...); });
  }
};

/// When a wheel was without contact, between the accepted steps that first saw it lost and found again.
struct ContactLoss {
  int spells{0};
  double total{0.0};         ///< [s]
  double longest{0.0};       ///< spell [s]
  double longest_from{0.0};  ///< when it began [s]

  void add(double from, double to);
  void state(auto& archive) { archive(spells, total, longest, longest_from); }
};

class ContactMonitor {
 public:
  explicit ContactMonitor(Model const& model)
      : lost_since_(model.contacts.size(), -1.0), losses_(model.contacts.size()) {}

  void reset();
  Status check(Model const& model, Evaluation const& evaluation, double t);

  ContactCounters const& counters() const { return counters_; }
  /// Per contact; a spell that lasts ends at the last check.
  std::vector<ContactLoss> losses() const;
  /// The contact that made the last check() fail; -1: none did.
  int failed_contact() const { return failed_contact_; }

  void state(auto& archive) {
    archive(lost_since_, losses_, checked_at_, counters_);
    archive.within(failed_contact_, -1, static_cast<int>(losses_.size()) - 1);
  }

 private:
  Status check_patch(Model const& model, Evaluation const& evaluation, int contact, int k);

  std::vector<double> lost_since_;   ///< per contact [s]; -1: it is there
  std::vector<ContactLoss> losses_;  ///< of spells that have ended
  double checked_at_{0.0};           ///< [s]
  ContactCounters counters_;
  int failed_contact_{-1};
};

}  // namespace rollerrig
