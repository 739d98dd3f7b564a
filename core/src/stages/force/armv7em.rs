//! Springs and volume for the Cortex-M4F and M7, in assembly.
//!
//! The Rust versions in `spring::by_rows` and `volume` define what is computed; this code adds the
//! same sum in the same order, hence the same bits (`board_and_desktop_give_the_same_bits`). The
//! compiler loads a node word by word at two cycles each, because it does not assign consecutive
//! registers to gathered values. Here a node is loaded in one instruction at one cycle per word,
//! and wherever possible another instruction separates a result from its use.
//!
//! This is sound for every model, checked or not: [`measure`] and [`springs`] check each index
//! before they use it and stop at the first one out of range, as the Rust versions do. [`Measured`]
//! is the proof that spares [`push`] a second check.
//!
//! * in: positions
//! * out: adds to `node.f`, `node.p`
//! * cost (M4F, by the cycle table): 70 + 146 cycles per tet, 76 per spring
//! * failures: none

#![expect(unsafe_code, reason = "assembly follows pointers")]

use core::arch::naked_asm;
use core::mem::offset_of;

use super::compensation::{BARRIER_BELOW, BARRIER_SLOPE};
use crate::model::{Model, Spring, Tet};
use crate::state::{Node, State};

/// Distance from one node to the next [bytes].
const NODE: usize = size_of::<Node>();

const _: () = assert!(offset_of!(Node, x) == offset_of!(Node, f) + 12 && offset_of!(Node, p) == offset_of!(Node, x) + 12);
const _: () = assert!(size_of::<Tet>() == 20 && offset_of!(Tet, six_volume_reciprocal) == 8);
const _: () = assert!(offset_of!(Tet, bulk) == 12 && offset_of!(Tet, barrier) == 16);
const _: () = assert!(size_of::<Spring>() == 12 && offset_of!(Spring, j) == 2);
const _: () = assert!(offset_of!(Spring, k) == 4 && offset_of!(Spring, k_rest) == 8);
// the constant in a `vmov` instruction below
const _: () = assert!(BARRIER_SLOPE == 2.5);

/// Index of the last node, `None` without nodes, and never larger than the assembly can use:
/// `smlabb` treats an index as a signed half-word.
fn last(nodes: &[Node]) -> Option<u32> {
    Some(nodes.len().checked_sub(1)?.min(i16::MAX.unsigned_abs().into()) as u32)
}

/// Tets whose corners are all among this many nodes.
#[derive(Clone, Copy)]
pub(super) struct Measured<'a> {
    tets: &'a [Tet],
    nodes: usize,
}

/// Adds six times the volume of every tet to `p` of its nodes [m^3].
pub(super) fn measure<'a>(tets: &'a [Tet], state: &mut State) -> Option<Measured<'a>> {
    let (last, nodes) = (last(state.nodes)?, state.nodes.len());
    let first = state.nodes.as_mut_ptr();
    // SAFETY: reads `tets` from end to end; writes `p` of nodes up to `last` alone, which exist.
    let whole = tets.is_empty() || unsafe { measure_tets(tets.as_ptr(), tets.len(), first, last | last << 16) };
    whole.then_some(Measured { tets, nodes })
}

/// Pushes every tet's nodes along its volume gradients.
pub(super) fn push<const BARRIER: bool>(Measured { tets, nodes }: Measured, state: &mut State) {
    // no volume ratio is below minus infinity, so the barrier never acts
    let barrier_below = if BARRIER { BARRIER_BELOW } else { f32::NEG_INFINITY };
    if !tets.is_empty() && nodes == state.nodes.len() {
        // SAFETY: reads `tets` from end to end; writes `f` of their corners, which `measure` found
        // among as many nodes.
        unsafe { push_tets(tets.as_ptr(), tets.len(), state.nodes.as_mut_ptr(), barrier_below) }
    }
}

/// Operands of [`pull_rows`], in the order of its registers.
#[repr(C)]
struct Rows {
    springs: *const Spring,
    count: usize,
    row: *const u16,
    rows_end: *const u16,
    last: u32,
    node: *mut Node,
}

/// Adds the forces of all springs, one node at a time; springs shorter than `onset` times their
/// rest length have `chi` times their own stiffness in addition.
pub(super) fn springs(model: &Model, nodes: &mut [Node], onset: f32, chi: f32) {
    let Model { springs, spring_rows: rows, .. } = model;
    let rows = rows.get(..nodes.len()).unwrap_or(rows);
    let Some(last) = last(nodes).filter(|_| !rows.is_empty()) else { return };
    let node = nodes.as_mut_ptr();
    let rows = rows.as_ptr_range();
    let rows = Rows { springs: springs.as_ptr(), count: springs.len(), row: rows.start, rows_end: rows.end, last, node };
    // SAFETY: reads rows to their end and as many springs as there are; writes `f` of nodes up to
    // `last` and of one per row, all of which exist.
    unsafe { pull_rows(&rows, onset, chi) }
}

/// Stops and returns false at the first tet with a node beyond `last`, which is stored in both
/// halves of its word.
#[unsafe(naked)]
unsafe extern "C" fn measure_tets(tets: *const Tet, count: usize, nodes: *mut Node, last: u32) -> bool {
    // r0 tet, r1 tets left, r2 x of the first node, r3 last, r6 r7 r8 r12 corners a b c d, lr size
    // s0-s2 a, s3 its p, s4-s7 b, s8-s11 c, s12-s15 d
    naked_asm!(
        env!("PALPATE_PROCESSOR"),
        "push {{r4-r8, lr}}",
        "vpush {{d8-d9}}",
        "add r2, #{x}",
        "mov lr, #{node}",
        "1: ldrd r4, r5, [r0], #20",
        "uqsub16 r6, r4, r3",
        "uqsub16 r7, r5, r3",
        "orrs r6, r7",
        "bne 2f",
        "smlabb r6, r4, lr, r2",
        "smlatb r7, r4, lr, r2",
        "smlabb r8, r5, lr, r2",
        "smlatb r12, r5, lr, r2",
        "vldmia r6, {{s0-s3}}",
        "vldmia r8, {{s8-s11}}",
        "vldmia r12, {{s12-s15}}",
        "vldmia r7, {{s4-s7}}",
        // edges from a: c, d, b
        "vsub.f32 s9, s9, s1",
        "vsub.f32 s14, s14, s2",
        "vsub.f32 s10, s10, s2",
        "vsub.f32 s13, s13, s1",
        "vsub.f32 s8, s8, s0",
        "vsub.f32 s12, s12, s0",
        "vsub.f32 s4, s4, s0",
        "vsub.f32 s5, s5, s1",
        "vsub.f32 s6, s6, s2",
        // c x d
        "vmul.f32 s16, s9, s14",
        "vmul.f32 s17, s10, s12",
        "vmul.f32 s18, s8, s13",
        "vmul.f32 s0, s10, s13",
        "vmul.f32 s1, s8, s14",
        "vmul.f32 s2, s9, s12",
        "vsub.f32 s16, s16, s0",
        "vsub.f32 s17, s17, s1",
        "vsub.f32 s18, s18, s2",
        // b . (c x d)
        "vmul.f32 s16, s4, s16",
        "vmul.f32 s17, s5, s17",
        "vmul.f32 s18, s6, s18",
        "vadd.f32 s16, s16, s17",
        "subs r1, #1",
        "vadd.f32 s16, s16, s18",
        "vadd.f32 s3, s3, s16",
        "vadd.f32 s7, s7, s16",
        "vadd.f32 s11, s11, s16",
        "vadd.f32 s15, s15, s16",
        "vstr s3, [r6, #12]",
        "vstr s7, [r7, #12]",
        "vstr s11, [r8, #12]",
        "vstr s15, [r12, #12]",
        "bne 1b",
        "mov r6, #0",
        "2: clz r0, r6", // 32 for zero
        "lsr r0, #5",
        "vpop {{d8-d9}}",
        "pop {{r4-r8, pc}}",
        x = const offset_of!(Node, x),
        node = const NODE,
    )
}

#[unsafe(naked)]
unsafe extern "C" fn push_tets(tets: *const Tet, count: usize, nodes: *mut Node, barrier_below: f32) {
    // r0 tet, r1 tets left, r2 x of the first node, r6 r7 r8 r12 corners a b c d, lr size
    // s0-s2 a, s3 its p and later the sum of pressures, s4-s6 b, s8-s10 c, s12-s14 d, s7 s11 s15
    // their p; s16-s18 the tet's constants; s19-s27 gradients; s28 barrier_below, s29 -1, s30 -2.5
    naked_asm!(
        env!("PALPATE_PROCESSOR"),
        "push {{r4-r8, lr}}",
        "vpush {{d8-d15}}",
        "vmov.f32 s28, s0",
        "vmov.f32 s29, #-1.0",
        "vmov.f32 s30, #-2.5",
        "add r2, #{x}",
        "mov lr, #{node}",
        "1: ldrd r4, r5, [r0], #8",
        "smlabb r6, r4, lr, r2",
        "smlatb r7, r4, lr, r2",
        "smlabb r8, r5, lr, r2",
        "smlatb r12, r5, lr, r2",
        "vldmia r6, {{s0-s3}}",
        "vldmia r8, {{s8-s11}}",
        "vldmia r12, {{s12-s15}}",
        "vldmia r7, {{s4-s7}}",
        "vldmia r0!, {{s16-s18}}",
        // edges from a: c, d, b
        "vsub.f32 s9, s9, s1",
        "vsub.f32 s14, s14, s2",
        "vsub.f32 s10, s10, s2",
        "vsub.f32 s13, s13, s1",
        "vsub.f32 s8, s8, s0",
        "vsub.f32 s12, s12, s0",
        "vsub.f32 s4, s4, s0",
        "vsub.f32 s5, s5, s1",
        "vsub.f32 s6, s6, s2",
        // gradient at b, c x d, and the nodes' pressures
        "vmul.f32 s19, s9, s14",
        "vmul.f32 s20, s10, s12",
        "vmul.f32 s21, s8, s13",
        "vmul.f32 s0, s10, s13",
        "vmul.f32 s1, s8, s14",
        "vmul.f32 s2, s9, s12",
        "vadd.f32 s3, s3, s7",
        "vadd.f32 s11, s11, s15",
        "vsub.f32 s19, s19, s0",
        "vsub.f32 s20, s20, s1",
        "vsub.f32 s21, s21, s2",
        "vadd.f32 s3, s3, s11",
        // volume b . (c x d) and half of the gradient at c, d x b
        "vmul.f32 s0, s4, s19",
        "vmul.f32 s1, s5, s20",
        "vmul.f32 s2, s6, s21",
        "vmul.f32 s22, s13, s6",
        "vadd.f32 s0, s0, s1",
        "vmul.f32 s23, s14, s4",
        "vadd.f32 s0, s0, s2",
        "vmul.f32 s24, s12, s5",
        // share of the rest volume, pressure
        "vmul.f32 s0, s0, s16",
        "vmul.f32 s7, s14, s5",
        "vadd.f32 s1, s0, s29",
        "vcmp.f32 s0, s28",
        "vmul.f32 s1, s17, s1",
        "vmul.f32 s11, s12, s6",
        "vmrs APSR_nzcv, fpscr",
        "vadd.f32 s3, s3, s1",
        "bmi 3f",
        "2: vmul.f32 s15, s13, s4",
        "vsub.f32 s22, s22, s7",
        "vsub.f32 s23, s23, s11",
        // gradient at d, b x c
        "vmul.f32 s25, s5, s10",
        "vsub.f32 s24, s24, s15",
        "vmul.f32 s26, s6, s8",
        "vmul.f32 s27, s4, s9",
        "vmul.f32 s7, s6, s9",
        "vmul.f32 s11, s4, s10",
        "vmul.f32 s15, s5, s8",
        "vsub.f32 s25, s25, s7",
        "vsub.f32 s26, s26, s11",
        "vsub.f32 s27, s27, s15",
        // pressure times gradients
        "vmul.f32 s19, s3, s19",
        "vmul.f32 s20, s3, s20",
        "vmul.f32 s21, s3, s21",
        "vmul.f32 s22, s3, s22",
        "vmul.f32 s23, s3, s23",
        "vmul.f32 s24, s3, s24",
        "vmul.f32 s25, s3, s25",
        "vmul.f32 s26, s3, s26",
        "vmul.f32 s27, s3, s27",
        // corner a takes the opposite of the sum
        "vldmdb r6!, {{s0-s2}}",
        "vadd.f32 s4, s19, s22",
        "vadd.f32 s5, s20, s23",
        "vadd.f32 s6, s21, s24",
        "vadd.f32 s4, s4, s25",
        "vadd.f32 s5, s5, s26",
        "vadd.f32 s6, s6, s27",
        "vadd.f32 s0, s0, s4",
        "vadd.f32 s1, s1, s5",
        "vadd.f32 s2, s2, s6",
        "vstmia r6, {{s0-s2}}",
        "vldmdb r7!, {{s4-s6}}",
        "vsub.f32 s4, s4, s19",
        "vsub.f32 s5, s5, s20",
        "vsub.f32 s6, s6, s21",
        "vstmia r7, {{s4-s6}}",
        "vldmdb r8!, {{s8-s10}}",
        "vsub.f32 s8, s8, s22",
        "vsub.f32 s9, s9, s23",
        "vsub.f32 s10, s10, s24",
        "vstmia r8, {{s8-s10}}",
        "vldmdb r12!, {{s12-s14}}",
        "subs r1, #1",
        "vsub.f32 s12, s12, s25",
        "vsub.f32 s13, s13, s26",
        "vsub.f32 s14, s14, s27",
        "vstmia r12, {{s12-s14}}",
        "bne 1b",
        "vpop {{d8-d15}}",
        "pop {{r4-r8, pc}}",
        // the barrier, for a tet that is nearly flat
        "3: vsub.f32 s1, s0, s28",
        "vmul.f32 s1, s1, s18",
        "vmul.f32 s1, s1, s30",
        "vsub.f32 s3, s3, s1",
        "b 2b",
        x = const offset_of!(Node, x),
        node = const NODE,
    )
}

#[unsafe(naked)]
unsafe extern "C" fn pull_rows(rows: &Rows, onset: f32, chi: f32) {
    // r0 spring, r1 springs left, r2 row, r3 end of rows, r4 last, r5 f of the row's node, r6 f of
    // the first node, r7 springs of the row, r8 other end, lr size
    // s0-s2 f of the other end, s3-s5 its x and then the force, s6 k, s7 k_rest, s10-s12 own f,
    // s13-s15 own x, s16 onset, s17 chi
    naked_asm!(
        env!("PALPATE_PROCESSOR"),
        "push {{r4-r8, lr}}",
        "vpush {{d8-d9}}",
        "ldmia r0, {{r0-r5}}",
        "add r5, #{f}",
        "mov r6, r5",
        "mov lr, #{node}",
        "vmov.f32 s16, s0",
        "vmov.f32 s17, s1",
        "1: ldrh r7, [r2], #2",
        "subs r1, r1, r7",
        "blo 4f",
        "cmp r7, #0",
        "beq 3f",
        "vldmia r5, {{s10-s15}}",
        "2: ldr r8, [r0], #4",
        "cmp r4, r8, lsr #16",
        "blo 4f",
        "smlatb r8, r8, lr, r6",
        "vldmia r8, {{s0-s5}}",
        "vsub.f32 s3, s3, s13",
        "vsub.f32 s4, s4, s14",
        "vsub.f32 s5, s5, s15",
        "vmul.f32 s8, s3, s3",
        "vmul.f32 s9, s4, s4",
        "vmul.f32 s18, s5, s5",
        "vadd.f32 s8, s8, s9",
        "vldmia r0!, {{s6-s7}}",
        "vadd.f32 s8, s8, s18",
        "vsqrt.f32 s8, s8",
        "vdiv.f32 s8, s7, s8",
        "vmul.f32 s9, s16, s8",
        "vsub.f32 s9, s6, s9",
        "vsub.f32 s8, s6, s8",
        "vcmp.f32 s9, #0",
        "vmrs APSR_nzcv, fpscr",
        "itt mi",
        "vmulmi.f32 s9, s17, s9",
        "vaddmi.f32 s8, s8, s9",
        "subs r7, #1",
        "vmul.f32 s3, s3, s8",
        "vmul.f32 s4, s4, s8",
        "vmul.f32 s5, s5, s8",
        "vsub.f32 s0, s0, s3",
        "vsub.f32 s1, s1, s4",
        "vsub.f32 s2, s2, s5",
        "vadd.f32 s10, s10, s3",
        "vadd.f32 s11, s11, s4",
        "vadd.f32 s12, s12, s5",
        "vstmia r8, {{s0-s2}}",
        "bne 2b",
        "vstmia r5, {{s10-s12}}",
        "3: add r5, lr",
        "cmp r2, r3",
        "bne 1b",
        "4: vpop {{d8-d9}}",
        "pop {{r4-r8, pc}}",
        f = const offset_of!(Node, f),
        node = const NODE,
    )
}
