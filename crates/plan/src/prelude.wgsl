// Appended to the text of every kernel: how a thread finds its number. A dispatch of more
// workgroups than fit into one row has several rows.

// Threads of a workgroup: the same number as `WORKGROUP` in program.rs.
const WORKGROUP: u32 = 256u;

struct Thread {
    @builtin(global_invocation_id) id: vec3<u32>,
    @builtin(num_workgroups) groups: vec3<u32>,
}

// A thread's number, counted from 0 over all workgroups. The last ones of a dispatch may have
// nothing to do.
fn number_of(thread: Thread) -> u32 {
    return thread.id.x + thread.id.y * thread.groups.x * WORKGROUP;
}
