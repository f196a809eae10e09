#pragma once

#include <string>
#include <vector>

#include "core/adjust/bundle.h"

namespace rigcal {

/// Parts of a rig that are not where it has them, or not as it has them.
struct LetGo {
  struct Mount {
    int camera;
    std::vector<int> others;  ///< which could as well be the ones that moved
  };
  std::vector<Mount> mounts;
  std::vector<int> stops;
};

/// Finds the camera or the stop that the pictures have moved farthest from the rig's prior, if that is as unlikely as
/// `sigmas` of one number, widens the prior of its mount or errors so that it pulls on nothing any more, and adds it to
/// `let_go`. One at a time: what moved drags others along until it is let go. Stops are judged against the median of
/// those that were seen, from three of them on. False when there is none.
bool LetGoOfWorst(const BundleUnknowns& solution, double sigmas, RigTerms& rig, LetGo& let_go);

/// A sentence for each that is beyond the limit in the end, too: what moved, by how much, and what cannot be decided;
/// and for each lens that the pictures pull away from what the chart said. `rig`: as it was before.
std::vector<std::string> SentencesOf(const LetGo& let_go, double sigmas, const BundleUnknowns& solution,
                                     const RigTerms& rig);

/// Those of them that are of stops.
std::vector<std::string> SlipSentences(const LetGo& let_go, double sigmas, const BundleUnknowns& solution,
                                       const RigTerms& rig);

/// Whether nothing is left that tells how large everything is: a turntable does not know lengths, and every camera that
/// saw something was let go.
bool ScaleIsLost(const LetGo& let_go, const BundleUnknowns& solution);

}  // namespace rigcal
