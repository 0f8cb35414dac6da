//! The collapse sequence: what a simplifier writes and every model reads.
//!
//! Vertices are numbered in the order in which they disappear. Record `k` removes vertex `k`, which
//! becomes `targets[k] > k`; the last vertex stays. LOD `k` is the mesh after the first `k`
//! records: LOD 0 is the input, `records()` the single vertex. Consecutive records of one half-edge
//! collapse make a *step*; a LOD is shown at step ends only. (Ripollés 2009, 3.2.1, 4.2.1 and 5.2.)

/// Number of records applied. 0 is the full mesh; larger is coarser.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Lod(pub u32);

/// One half-edge collapse.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Step {
    /// The LOD after the step.
    pub lod: Lod,
    /// Error of that LOD in the mesh's units; never smaller than that of the step before, infinite
    /// where a mesh that had triangles has none left.
    pub error: f32,
    /// Triangles of that LOD.
    pub triangles: u32,
}

/// Parts of a collapse sequence before they are known to be valid.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SequenceParts {
    /// The vertex that each record's vertex becomes; one fewer than there are vertices.
    pub targets: Vec<u32>,
    /// The LOD after each step, rising; the last is the number of records.
    pub step_ends: Vec<u32>,
    /// The error after each step, never falling: the Hausdorff distance from LOD 0 if there are
    /// `step_rms`, else an estimate. Infinite only where no triangle is left.
    pub step_errors: Vec<f32>,
    /// The root mean square distance from LOD 0 after each step, never falling and never above the
    /// error. Empty if nothing was measured.
    pub step_rms: Vec<f32>,
    /// The live triangles after each step, never rising.
    pub step_triangles: Vec<u32>,
    /// Triangles at LOD 0.
    pub triangles: u32,
    /// The last LOD reached without breaking a rule of legality (the terminal phase comes after
    /// it).
    pub last_legal_lod: Lod,
    /// Number of steps that changed the topology before the terminal phase.
    pub topology_changes: u32,
    /// The first LOD after such a step.
    pub first_topology_change: Option<Lod>,
}

/// Records between two entries of the index of step ends. Chosen by hand: more take less memory and
/// a longer search.
const INDEX_STRIDE: usize = 32;

/// A valid collapse sequence.
#[derive(Clone, Debug, PartialEq)]
pub struct CollapseSequence {
    parts: SequenceParts,
    step_index: StepIndex,
}

/// Number of complete steps at every [`INDEX_STRIDE`]th LOD, so that the step of a LOD is found in
/// a few reads.
#[derive(Clone, Debug, PartialEq)]
struct StepIndex(Vec<u32>);

impl StepIndex {
    fn new(step_ends: &[u32], records: usize) -> Self {
        let mut steps = 0;
        let mut complete_steps = |lod: usize| {
            while step_ends.get(steps).is_some_and(|&end| end as usize <= lod) {
                steps += 1;
            }
            steps as u32
        };
        // The last entry is the number of all steps.
        Self(
            (0..records / INDEX_STRIDE + 2)
                .map(|i| complete_steps((INDEX_STRIDE * i).min(records)))
                .collect(),
        )
    }

    /// Returns the number of complete steps at a LOD, which is not beyond the last.
    fn complete_steps(&self, step_ends: &[u32], lod: usize) -> usize {
        let [at_or_before, at_next] =
            [self.0[lod / INDEX_STRIDE], self.0[lod / INDEX_STRIDE + 1]].map(|n| n as usize);
        // Each step has at least one record, so there are no more steps between two LODs than
        // records.
        let records_before = lod % INDEX_STRIDE;
        let records_after = INDEX_STRIDE - records_before;
        let min_steps = at_or_before.max(at_next.saturating_sub(records_after));
        let max_steps = at_next.min(at_or_before + records_before);
        min_steps + step_ends[min_steps..max_steps].partition_point(|&end| end as usize <= lod)
    }
}

impl CollapseSequence {
    /// Number of records, one fewer than there are vertices.
    #[must_use]
    pub fn records(&self) -> u32 {
        self.parts.targets.len() as u32
    }
    /// Number of steps.
    #[must_use]
    pub fn steps(&self) -> usize {
        self.parts.step_ends.len()
    }
    /// One step, counted from 0.
    #[must_use]
    pub fn step(&self, i: usize) -> Step {
        Step {
            lod: Lod(self.parts.step_ends[i]),
            error: self.parts.step_errors[i],
            triangles: self.parts.step_triangles[i],
        }
    }
    /// For each record the LOD at the end of its step: the first LOD shown without its vertex.
    #[must_use]
    pub fn step_ends_by_record(&self) -> Vec<u32> {
        let mut ends = Vec::with_capacity(self.parts.targets.len());
        for &end in &self.parts.step_ends {
            ends.resize(end as usize, end);
        }
        ends
    }
    /// Target of each record's vertex.
    #[must_use]
    pub fn targets(&self) -> &[u32] {
        &self.parts.targets
    }
    /// The parts, for storing them.
    #[must_use]
    pub fn parts(&self) -> &SequenceParts {
        &self.parts
    }
    /// The parts, for changing them.
    #[must_use]
    pub fn into_parts(self) -> SequenceParts {
        self.parts
    }
    /// The coarsest LOD: one vertex.
    #[must_use]
    pub fn last(&self) -> Lod {
        Lod(self.records())
    }
    /// Number of complete steps at `lod`.
    #[must_use]
    pub fn steps_at(&self, lod: Lod) -> usize {
        self.step_index.complete_steps(&self.parts.step_ends, lod.min(self.last()).0 as usize)
    }
    /// The LOD that is shown for `lod`: rounded down, towards finer, to the end of a step.
    #[must_use]
    pub fn floor(&self, lod: Lod) -> Lod {
        match self.steps_at(lod) {
            0 => Lod(0),
            n => Lod(self.parts.step_ends[n - 1]),
        }
    }
    /// Live triangles at the LOD shown for `lod`.
    #[must_use]
    pub fn triangles_at(&self, lod: Lod) -> u32 {
        match self.steps_at(lod) {
            0 => self.parts.triangles,
            n => self.parts.step_triangles[n - 1],
        }
    }
    /// Object-space error at the LOD shown for `lod`, in the mesh's units.
    #[must_use]
    pub fn error_at(&self, lod: Lod) -> f32 {
        match self.steps_at(lod) {
            0 => 0.0,
            n => self.parts.step_errors[n - 1],
        }
    }
    /// Returns whether errors are measured distances, not estimates.
    #[must_use]
    pub fn is_measured(&self) -> bool {
        self.parts.step_rms.len() == self.steps()
    }
    /// Root mean square distance at the LOD shown for `lod`, in the mesh's units; none if it was
    /// not measured.
    #[must_use]
    pub fn rms_at(&self, lod: Lod) -> Option<f32> {
        self.is_measured().then(|| match self.steps_at(lod) {
            0 => 0.0,
            n => self.parts.step_rms[n - 1],
        })
    }
    /// The coarsest LOD whose root mean square distance is at most `rms`; none if it was not
    /// measured.
    #[must_use]
    pub fn lod_for_rms(&self, rms: f32) -> Option<Lod> {
        self.is_measured().then(|| match self.parts.step_rms.partition_point(|&e| e <= rms) {
            0 => Lod(0),
            n => Lod(self.parts.step_ends[n - 1]),
        })
    }
    /// The finest LOD with at most `triangles` triangles.
    #[must_use]
    pub fn lod_for_triangles(&self, triangles: u32) -> Lod {
        if self.parts.triangles <= triangles {
            return Lod(0);
        }
        let step = self.parts.step_triangles.partition_point(|&t| t > triangles);
        self.parts.step_ends.get(step).map_or(self.last(), |&end| Lod(end))
    }
    /// The coarsest LOD whose error is at most `error`.
    #[must_use]
    pub fn lod_for_error(&self, error: f32) -> Lod {
        match self.parts.step_errors.partition_point(|&e| e <= error) {
            0 => Lod(0),
            n => Lod(self.parts.step_ends[n - 1]),
        }
    }
    /// The coarsest LOD that still has a triangle (LOD 0 if there is none at all).
    #[must_use]
    pub fn last_visible(&self) -> Lod {
        match self.parts.step_triangles.partition_point(|&t| t > 0) {
            0 => Lod(0),
            n => Lod(self.parts.step_ends[n - 1]),
        }
    }
    /// The vertex that `vertex` has become at `lod` (at the coarsest LOD, if `lod` is beyond it).
    #[must_use]
    pub fn resolve(&self, mut vertex: u32, lod: Lod) -> u32 {
        let end = lod.min(self.last()).0;
        while vertex < end {
            vertex = self.parts.targets[vertex as usize];
        }
        vertex
    }
    /// [`Self::resolve`] for all vertices at once, in linear time.
    #[must_use]
    pub fn resolve_all(&self, lod: Lod) -> Vec<u32> {
        let mut map = Vec::with_capacity(self.records() as usize + 1);
        self.resolve_gone(lod, &mut map);
        map.extend(map.len() as u32..=self.records());
        map
    }
    /// [`Self::resolve`] for the vertices that have disappeared at `lod`, the first ones; all
    /// others are themselves. `resolved` is cleared first.
    pub fn resolve_gone(&self, lod: Lod, resolved: &mut Vec<u32>) {
        let end = lod.min(self.last()).0 as usize;
        resolved.clear();
        resolved.extend_from_slice(&self.parts.targets[..end]);
        for k in (0..end).rev() {
            if let Some(&further) = resolved.get(resolved[k] as usize) {
                resolved[k] = further;
            }
        }
    }
}

impl TryFrom<SequenceParts> for CollapseSequence {
    type Error = SequenceError;

    fn try_from(p: SequenceParts) -> Result<Self, SequenceError> {
        let records = p.targets.len();
        if let Some(record) =
            (0..records).find(|&k| p.targets[k] as usize <= k || p.targets[k] as usize > records)
        {
            return Err(SequenceError::Target { record });
        }
        let steps = p.step_ends.len();
        if p.step_errors.len() != steps || p.step_triangles.len() != steps {
            return Err(SequenceError::Lengths);
        }
        if !p.step_rms.is_empty() && p.step_rms.len() != steps {
            return Err(SequenceError::Lengths);
        }
        let (mut end, mut triangles) = (0, p.triangles);
        let (mut error, mut rms) = (0.0, 0.0);
        for step in 0..steps {
            let next_error = p.step_errors[step];
            let next_rms = p.step_rms.get(step).copied().unwrap_or(rms);
            let is_empty = p.step_triangles[step] == 0 && p.triangles > 0;
            let is_valid = p.step_ends[step] > end
                && p.step_triangles[step] <= triangles
                && next_error >= error
                && (next_error.is_finite() || is_empty)
                && next_rms >= rms
                && next_rms <= next_error;
            if !is_valid {
                return Err(SequenceError::Step { step });
            }
            (end, triangles) = (p.step_ends[step], p.step_triangles[step]);
            (error, rms) = (next_error, next_rms);
        }
        if end as usize != records
            || p.last_legal_lod.0 > end
            || p.first_topology_change.is_some_and(|l| l.0 > end)
        {
            return Err(SequenceError::Step { step: steps });
        }
        let step_index = StepIndex::new(&p.step_ends, records);
        Ok(Self { parts: p, step_index })
    }
}

/// Why parts are not a collapse sequence. Each variant names the first offender.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SequenceError {
    /// A record's target is not a later vertex.
    #[error("record {record} does not lead to a later vertex")]
    Target {
        /// The record.
        record: usize,
    },
    /// Steps have different numbers of ends, errors and triangle counts.
    #[error("steps have different numbers of ends, errors and triangle counts")]
    Lengths,
    /// A step does not follow the one before it: its end, error or root mean square distance falls,
    /// its triangles rise, its error is no distance, or the last step does not end with the last
    /// record.
    #[error("step {step} does not follow the one before it")]
    Step {
        /// The step.
        step: usize,
    },
}
