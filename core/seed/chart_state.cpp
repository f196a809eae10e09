#include "core/seed/chart_state.h"

#include "core/rig/rig_model_pose.h"

namespace rigcal {

Rigid3d WorldFromBoard(const BoardPlace& place, double thickness_m) {
  return {ExpRotation({place[0], place[1], 0}), {place[2], place[3], thickness_m}};
}

Rigid3d CamFromBoard(const ChartTerms& terms, const ChartState& state, int view) {
  const ChartView& seen = terms.views[view];
  if (!seen.stop) return state.cam_from_board[view];
  const StopMotion motion = MotionAt(state.rig.positioner, terms.stops[*seen.stop], state.stop_errors[*seen.stop]);
  return CamFromWorld(*state.rig.cam_from_mount[seen.camera], motion) *
         WorldFromBoard(state.place, terms.board.thickness_m);
}

}  // namespace rigcal
