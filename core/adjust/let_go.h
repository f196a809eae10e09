#pragma once

#include <string>
#include <vector>

#include "core/adjust/bundle.h"

namespace rigcal {

/// Parts of a rig that are not where it has them.
struct LetGo {
  struct Mount {
    int camera;
    std::vector<int> others;  ///< which could as well be the ones that moved
  };
  std::vector<Mount> mounts;
  std::vector<int> stops;
};

/// Finds the camera or the stop that the pictures have moved farthest beyond `sigmas` from the rig's prior, widens the
/// prior of its mount or errors so that it pulls on nothing any more, and adds it to `let_go`. One at a time: what
/// moved drags others along until it is let go. False when there is none.
bool LetGoOfWorst(const BundleUnknowns& solution, double sigmas, RigTerms& rig, LetGo& let_go);

/// A sentence for each: what moved, by how much it did in the end, and what cannot be decided. `rig`: as it was before.
std::vector<std::string> SentencesOf(const LetGo& let_go, const BundleUnknowns& solution, const RigTerms& rig);

}  // namespace rigcal
