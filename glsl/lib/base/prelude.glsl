// What every kernel starts from. Include first.
#extension GL_EXT_scalar_block_layout : require
#extension GL_EXT_control_flow_attributes : require
#include "abi.glsl"

// Which item this invocation works on; large dispatches are folded into rows of GROUPS_PER_ROW groups.
uint group_index() {
    return gl_WorkGroupID.y * GROUPS_PER_ROW + gl_WorkGroupID.x;
}
uint item_index() {
    // Not gl_WorkGroupSize: it is 1 before the kernel declares its size.
    return group_index() * workgroup + gl_LocalInvocationID.x;
}
