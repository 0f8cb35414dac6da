// Ends every kernel: the number of a thread. Workgroups that do not fit into a row lie in several.

const WORKGROUP: u32 = 256u;

struct Thread {
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
}

fn number_of(thread: Thread) -> u32 {
    return thread.id.x + thread.id.y * thread.groups.x * WORKGROUP;
}
