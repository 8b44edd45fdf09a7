// Which children the rays of a subgroup have: bit `lane` of the low half of a word says that there is a reflection ray,
// the same bit of the high half a refraction ray.
const uint REFLECTED_BIT = 1u;
const uint REFRACTED_BIT = 0x10000u;
// Words of a workgroup.
const uint MASKS = lanes != 0u ? workgroup / (lanes + (lanes == 0u ? 1u : 0u)) : 1u;
// Places of a ray's children.
const uint CHILDREN_MOST = branching != 0u ? 2u : 1u;
