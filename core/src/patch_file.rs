//! The packed patch: versioned, CRC-32, read in place.
//!
//! Little-endian, 4-byte aligned: a header, then the arrays of [`Model`] in the order of
//! `sections`, each padded to 4 bytes. A patch in flash is used in place; only the header is
//! copied. Elastic constants are per pascal, so the header's parameters are defaults that a caller
//! may change before [`Params::build`], except Poisson's ratio and the site of the press.
//!
//! Optional data follow the arrays, each announced by a bit in `terms`: the shares and times of
//! tissue that relaxes, the coefficient of a probe with friction, the exponent of tissue that
//! stiffens, and the steepness of its nodes if regions differ. For a capsule or an ellipsoid, as
//! given by `probe_shape`, a direction and lengths come next, and a law with its table comes last.
//! Files without these data keep the layout of before, and a reader that does not know a term or a
//! shape refuses the file.

use bytemuck::{Pod, Zeroable};
use crc::{CRC_32_ISO_HDLC, Crc};
use nalgebra::Vector3;

use crate::fault::BuildError;
use crate::law::{Law, LawShape};
use crate::model::Model;
use crate::params::{GuardLimits, MOST_TERMS, Params, Probe, ProbeShape, PronyTerm, Terms};

const MAGIC: [u8; 8] = *b"PALPATE\n";
const VERSION: u32 = 4;
const CRC: Crc<u32> = Crc::<u32>::new(&CRC_32_ISO_HDLC);

#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct Header {
    magic: [u8; 8],
    version: u32,
    /// CRC-32 of all that follows this field.
    crc: u32,
    /// Lengths in the order of `sections`.
    counts: [u32; 11],
    poisson_ratio: f32,
    stiffening_per_m: f32,
    depth_limit_m: f32,
    stable_dt_s: f32,
    site_m: [f32; 3],
    // defaults of `Params`
    youngs_modulus_pa: f32,
    density_kg_per_m3: f32,
    node_damping_per_s: f32,
    /// Must be zero: earlier files of version 3 stored a damping of the springs here.
    reserved: u32,
    gravity_m_per_s2: [f32; 3],
    compensation: f32,
    compensation_threshold: f32,
    mass_floor: f32,
    contact_damping: f32,
    substeps: u32,
    tick_s: f32,
    /// 0 hemisphere, 1 sphere, 2 flat; 3 capsule and 4 ellipsoid, with a `Tip` at the end.
    probe_shape: u32,
    probe_radius_m: f32,
    probe_axis: [f32; 3],
    max_speed_m_per_s: f32,
    max_sink_m_per_s: f32,
    max_force_n: f32,
    /// Bit 0: volume, 1: compensation, 2: rim, 3: relative mass, 7: smooth mass. The other bits
    /// announce data after the arrays, in this order: bit 4: relaxation (shares and times), 5:
    /// friction, 6: stiffening, 8: steepness of every node; after the tip bit 9: a law. Bits
    /// without a meaning are zero.
    terms: u32,
    /// Number of probe positions at which the constants were fitted; 0 if they come from formulas
    /// alone.
    fitted_places: u32,
}

const HEADER: usize = size_of::<Header>();
/// Share and time of each term of the relaxation.
type Relaxation = [[f32; 2]; MOST_TERMS];
/// Direction of a capsule or an ellipsoid and two lengths [m]: that of the capsule's segment and
/// zero, or two semi-axes.
type Tip = [f32; 5];
const RELAXES: u32 = 1 << 4;
const RUBS: u32 = 1 << 5;
const STIFFENS: u32 = 1 << 6;
const SMOOTH_MASS: u32 = 1 << 7;
const UNEVENLY: u32 = 1 << 8;
const LAW: u32 = 1 << 9;
/// Bits of `terms` that this build knows.
#[cfg(not(target_os = "none"))]
const KNOWN: u32 = 15 | RELAXES | RUBS | STIFFENS | SMOOTH_MASS | UNEVENLY | LAW;
#[cfg(target_os = "none")]
const KNOWN: u32 = 15 | RELAXES | RUBS | STIFFENS | SMOOTH_MASS | LAW;
/// Offset of the checksummed part, which begins after magic, version and checksum.
const CHECKED_FROM: usize = 16;

/// A patch file, read in place.
///
/// ```
/// use palpate::{BuildError, PatchFile};
///
/// // on a 4-byte boundary: a file is read as words
/// #[repr(C, align(4))]
/// struct Words<B: ?Sized>(B);
/// static BYTES: &Words<[u8]> = &Words(*include_bytes!(concat!(
///     env!("CARGO_MANIFEST_DIR"),
///     "/examples/block-m4f-168.patch"
/// )));
///
/// let file = PatchFile::open(&BYTES.0)?;
/// assert_eq!((file.model.nodes.len(), file.params.youngs_modulus_pa), (56, 3500.0));
/// let cut_short = PatchFile::open(&BYTES.0[..1000]);
/// assert!(matches!(cut_short, Err(BuildError::Checksum { .. })));
/// # Ok::<(), BuildError>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct PatchFile<'a> {
    /// The patch, whose lists lie in the file's bytes.
    pub model: Model<'a>,
    /// The parameters that it was packed with.
    pub params: Params,
    /// Point of the rest surface at which the patch is pressed [m].
    pub site_m: Vector3<f32>,
    /// Longest stable substep, measured on the pressed patch when it was packed [s].
    pub stable_dt_s: f32,
    /// Number of probe positions at which the constants were fitted; 0 if they come from formulas
    /// alone.
    pub fitted_places: u32,
}

impl<'a> PatchFile<'a> {
    /// Returns the checksum stored in a patch file, by which patches are told apart; `None` if the
    /// bytes are too short to hold one.
    #[must_use]
    pub fn checksum(bytes: &[u8]) -> Option<u32> {
        let field = core::mem::offset_of!(Header, crc);
        Some(u32::from_le_bytes(*bytes.get(field..CHECKED_FROM)?.first_chunk()?))
    }

    /// Opens a patch. The bytes must start on a 4-byte boundary.
    ///
    /// # Errors
    /// The bytes are not a patch file of this version, are truncated, damaged or misaligned, or
    /// hold a reserved word that is not zero or a probe shape that this build leaves out.
    pub fn open(bytes: &'a [u8]) -> Result<Self, BuildError> {
        let (head, mut body) = bytes.split_at_checked(HEADER).ok_or(BuildError::NotAPatch)?;
        let header: Header = bytemuck::pod_read_unaligned(head);
        if header.magic != MAGIC || header.version != VERSION {
            return Err(BuildError::NotAPatch);
        }
        let found = CRC.checksum(&bytes[CHECKED_FROM..]);
        if found != header.crc {
            return Err(BuildError::Checksum { expected: header.crc, found });
        }
        if header.terms & !KNOWN != 0 {
            return Err(BuildError::NotAPatch);
        }
        if header.reserved != 0 {
            return Err(BuildError::ReservedWord { found: header.reserved });
        }
        let [nodes, springs, tets, neighbours, triangles, owners, foundation, rim_nodes, rim_edges, anchors, rows] =
            header.counts;
        let mut model = Model {
            poisson_ratio: header.poisson_ratio,
            stiffening_per_m: header.stiffening_per_m,
            depth_limit_m: header.depth_limit_m,
            nodes: section(&mut body, nodes)?,
            springs: section(&mut body, springs)?,
            tets: section(&mut body, tets)?,
            neighbours: section(&mut body, neighbours)?,
            triangles: section(&mut body, triangles)?,
            #[cfg(not(target_os = "none"))]
            steepness: &[],
            owners: section(&mut body, owners)?,
            foundation: section(&mut body, foundation)?,
            rim_nodes: section(&mut body, rim_nodes)?,
            rim_edges: section(&mut body, rim_edges)?,
            anchors: section(&mut body, anchors)?,
            spring_rows: section(&mut body, rows)?,
            law: None,
        };
        let relaxation: Relaxation = match header.terms & RELAXES {
            0 => Relaxation::default(),
            _ => value(&mut body)?,
        };
        let friction: f32 = match header.terms & RUBS {
            0 => 0.0,
            _ => value(&mut body)?,
        };
        let stiffening_b: f32 = match header.terms & STIFFENS {
            0 => 0.0,
            _ => value(&mut body)?,
        };
        #[cfg(not(target_os = "none"))]
        if header.terms & UNEVENLY != 0 {
            model.steepness = section(&mut body, nodes)?;
        }
        let shape = match header.probe_shape {
            0 => ProbeShape::Hemisphere,
            1 => ProbeShape::Sphere,
            2 => ProbeShape::Flat,
            #[cfg(feature = "long-tips")]
            3 | 4 => {
                let [x, y, z, a, b]: Tip = value(&mut body)?;
                let along = Vector3::new(x, y, z);
                match header.probe_shape {
                    4 => ProbeShape::Ellipsoid { semi_axes_m: [a, b], along },
                    _ if b == 0.0 => ProbeShape::Capsule { length_m: a, along },
                    _ => return Err(BuildError::ReservedWord { found: b.to_bits() }),
                }
            }
            #[cfg(not(feature = "long-tips"))]
            3 | 4 => return Err(BuildError::NoSuchTip),
            _ => return Err(BuildError::NotAPatch),
        };
        if header.terms & LAW != 0 {
            let [shape]: &[LawShape; 1] = section(&mut body, 1)?.try_into().map_err(|_| BuildError::NotAPatch)?;
            let rows = shape.side.checked_mul(shape.side).ok_or(BuildError::NotAPatch)?;
            model.law = Some(Law { shape, table: section(&mut body, rows)? });
        }
        if !body.is_empty() {
            return Err(BuildError::NotAPatch);
        }
        let params = Params {
            youngs_modulus_pa: header.youngs_modulus_pa,
            poisson_ratio: header.poisson_ratio,
            density_kg_per_m3: header.density_kg_per_m3,
            node_damping_per_s: header.node_damping_per_s,
            gravity_m_per_s2: header.gravity_m_per_s2,
            compensation: header.compensation,
            compensation_threshold: header.compensation_threshold,
            mass_floor: header.mass_floor,
            contact_damping: header.contact_damping,
            stiffening_b,
            relaxation: relaxation.map(|[share, time_s]| PronyTerm { share, time_s }),
            friction,
            substeps: u16::try_from(header.substeps).unwrap_or(u16::MAX),
            tick_s: header.tick_s,
            probe: Probe { shape, radius_m: header.probe_radius_m, axis: header.probe_axis.into() },
            #[cfg(feature = "long-tips")]
            orientation: Params::UPRIGHT,
            terms: Terms {
                volume: header.terms & 1 != 0,
                compensation: header.terms & 2 != 0,
                rim: header.terms & 4 != 0,
                relative_mass: header.terms & 8 != 0,
                smooth_mass: header.terms & SMOOTH_MASS != 0,
                stiffening: true,
                relaxation: true,
                friction: true,
                law: true,
            },
            limits: GuardLimits {
                max_speed_m_per_s: header.max_speed_m_per_s,
                max_sink_m_per_s: header.max_sink_m_per_s,
                max_force_n: header.max_force_n,
            },
        };
        Ok(Self {
            model,
            params,
            site_m: header.site_m.into(),
            stable_dt_s: header.stable_dt_s,
            fitted_places: header.fitted_places,
        })
    }

    /// Writes a patch, piece by piece. The model's springs must be sorted by their first nodes,
    /// with [`Model::spring_rows`].
    pub fn write(&self, mut sink: impl FnMut(&[u8])) {
        let (model, params) = (&self.model, &self.params);
        let stiffens = params.terms.stiffening && params.stiffening_b != 0.0;
        let stiffening: &[u8] = if stiffens { bytemuck::bytes_of(&params.stiffening_b) } else { &[] };
        #[cfg(not(target_os = "none"))]
        let steepness: &[u8] = if stiffens { bytemuck::cast_slice(model.steepness) } else { &[] };
        #[cfg(target_os = "none")]
        let steepness: &[u8] = &[];
        let relaxes = params.terms.relaxation && params.relaxation.iter().any(|term| term.share != 0.0);
        let relaxation: Relaxation = params.relaxation.map(|term| [term.share, term.time_s]);
        let relaxation = if relaxes { bytemuck::bytes_of(&relaxation) } else { &[] };
        let rubs = params.terms.friction && params.friction != 0.0;
        let friction = if rubs { bytemuck::bytes_of(&params.friction) } else { &[] };
        let (probe_shape, tip) = match params.probe.shape {
            ProbeShape::Hemisphere => (0, Tip::default()),
            ProbeShape::Sphere => (1, Tip::default()),
            ProbeShape::Flat => (2, Tip::default()),
            #[cfg(feature = "long-tips")]
            ProbeShape::Capsule { length_m, along } => (3, [along.x, along.y, along.z, length_m, 0.0]),
            #[cfg(feature = "long-tips")]
            ProbeShape::Ellipsoid { semi_axes_m: [a, b], along } => (4, [along.x, along.y, along.z, a, b]),
        };
        let tip: &[u8] = if probe_shape < 3 { &[] } else { bytemuck::bytes_of(&tip) };
        let (law, table): (&[u8], &[u8]) = match &model.law {
            Some(law) => (bytemuck::bytes_of(law.shape), bytemuck::cast_slice(law.table)),
            None => (&[], &[]),
        };
        let mut header = Header {
            magic: MAGIC,
            version: VERSION,
            crc: 0,
            counts: sections(model).map(|(_, count)| count),
            poisson_ratio: model.poisson_ratio,
            stiffening_per_m: model.stiffening_per_m,
            depth_limit_m: model.depth_limit_m,
            stable_dt_s: self.stable_dt_s,
            site_m: self.site_m.into(),
            youngs_modulus_pa: params.youngs_modulus_pa,
            density_kg_per_m3: params.density_kg_per_m3,
            node_damping_per_s: params.node_damping_per_s,
            reserved: 0,
            gravity_m_per_s2: params.gravity_m_per_s2,
            compensation: params.compensation,
            compensation_threshold: params.compensation_threshold,
            mass_floor: params.mass_floor,
            contact_damping: params.contact_damping,
            substeps: u32::from(params.substeps),
            tick_s: params.tick_s,
            probe_shape,
            probe_radius_m: params.probe.radius_m,
            probe_axis: params.probe.axis.into(),
            max_speed_m_per_s: params.limits.max_speed_m_per_s,
            max_sink_m_per_s: params.limits.max_sink_m_per_s,
            max_force_n: params.limits.max_force_n,
            terms: u32::from(params.terms.volume)
                | u32::from(params.terms.compensation) << 1
                | u32::from(params.terms.rim) << 2
                | u32::from(params.terms.relative_mass) << 3
                | if relaxes { RELAXES } else { 0 }
                | if rubs { RUBS } else { 0 }
                | if stiffens { STIFFENS } else { 0 }
                | if params.terms.smooth_mass { SMOOTH_MASS } else { 0 }
                | if steepness.is_empty() { 0 } else { UNEVENLY }
                | if law.is_empty() { 0 } else { LAW },
            fitted_places: self.fitted_places,
        };
        let mut digest = CRC.digest();
        digest.update(&bytemuck::bytes_of(&header)[CHECKED_FROM..]);
        for (bytes, _) in sections(model) {
            digest.update(bytes);
            digest.update(padding(bytes.len()));
        }
        digest.update(relaxation);
        digest.update(friction);
        digest.update(stiffening);
        digest.update(steepness);
        digest.update(tip);
        digest.update(law);
        digest.update(table);
        header.crc = digest.finalize();
        sink(bytemuck::bytes_of(&header));
        for (bytes, _) in sections(model) {
            sink(bytes);
            sink(padding(bytes.len()));
        }
        sink(relaxation);
        sink(friction);
        sink(stiffening);
        sink(steepness);
        sink(tip);
        sink(law);
        sink(table);
    }
}

/// The arrays of a model as bytes, with their lengths, in file order.
fn sections<'a>(model: &Model<'a>) -> [(&'a [u8], u32); 11] {
    fn one<T: Pod>(items: &[T]) -> (&[u8], u32) {
        (bytemuck::cast_slice(items), items.len() as u32)
    }
    [
        one(model.nodes),
        one(model.springs),
        one(model.tets),
        one(model.neighbours),
        one(model.triangles),
        one(model.owners),
        one(model.foundation),
        one(model.rim_nodes),
        one(model.rim_edges),
        one(model.anchors),
        one(model.spring_rows),
    ]
}

/// Zeros up to the next multiple of 4.
fn padding(length: usize) -> &'static [u8] {
    const ZEROS: [u8; 4] = [0; 4];
    &ZEROS[..length.wrapping_neg() % 4]
}

/// Takes a value off the front of `body`.
fn value<T: Pod>(body: &mut &[u8]) -> Result<T, BuildError> {
    let (taken, rest) = body.split_at_checked(size_of::<T>()).ok_or(BuildError::NotAPatch)?;
    *body = rest;
    Ok(bytemuck::pod_read_unaligned(taken))
}

/// Takes `count` items off the front of `body`.
fn section<'a, T: Pod>(body: &mut &'a [u8], count: u32) -> Result<&'a [T], BuildError> {
    let length = (count as usize).checked_mul(size_of::<T>()).ok_or(BuildError::NotAPatch)?;
    let padded = length.checked_next_multiple_of(4).ok_or(BuildError::NotAPatch)?;
    let (taken, rest) = body.split_at_checked(padded).ok_or(BuildError::NotAPatch)?;
    *body = rest;
    bytemuck::try_cast_slice(&taken[..length]).map_err(|_| BuildError::Misaligned)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// An empty patch, as words; it can be opened but not built.
    fn packed(params: Params) -> ([u32; HEADER / 4 + 5], usize) {
        let model = Model {
            poisson_ratio: 0.45,
            stiffening_per_m: 1.0,
            depth_limit_m: 1.0,
            nodes: &[],
            anchors: &[],
            spring_rows: &[],
            springs: &[],
            tets: &[],
            triangles: &[],
            steepness: &[],
            neighbours: &[],
            owners: &[],
            foundation: &[],
            rim_nodes: &[],
            rim_edges: &[],
            law: None,
        };
        let file = PatchFile { model, params, site_m: Vector3::zeros(), stable_dt_s: 1e-3, fitted_places: 0 };
        let (mut words, mut length) = ([0_u32; HEADER / 4 + 5], 0);
        file.write(|piece| {
            bytemuck::cast_slice_mut(&mut words)[length..][..piece.len()].copy_from_slice(piece);
            length += piece.len();
        });
        (words, length)
    }

    /// Corrects the checksum of changed bytes.
    fn sealed(words: &mut [u32], length: usize) -> &[u8] {
        words[3] = CRC.checksum(&bytemuck::cast_slice(words)[CHECKED_FROM..length]);
        &bytemuck::cast_slice(words)[..length]
    }

    #[test]
    fn a_reserved_word_must_be_zero() {
        let (mut words, length) = packed(Params::default());
        assert_eq!(length, HEADER);
        assert!(PatchFile::open(&bytemuck::cast_slice(&words)[..length]).is_ok());

        let header: &mut Header = bytemuck::from_bytes_mut(&mut bytemuck::cast_slice_mut(&mut words)[..HEADER]);
        header.reserved = 1e-5_f32.to_bits();
        let refused = PatchFile::open(sealed(&mut words, length)).map(|_| ());
        assert!(matches!(refused, Err(BuildError::ReservedWord { found }) if found == 1e-5_f32.to_bits()), "{refused:?}");
    }

    #[cfg(not(feature = "long-tips"))]
    #[test]
    fn a_build_without_long_tips_refuses_them_by_name() {
        let (mut words, length) = packed(Params::default());
        for shape in [3, 4] {
            let header: &mut Header = bytemuck::from_bytes_mut(&mut bytemuck::cast_slice_mut(&mut words)[..HEADER]);
            header.probe_shape = shape;
            let refused = PatchFile::open(sealed(&mut words, length + size_of::<Tip>())).map(|_| ());
            assert_eq!(refused, Err(BuildError::NoSuchTip));
        }
    }

    #[cfg(feature = "long-tips")]
    #[test]
    fn a_long_tip_comes_back_and_a_damaged_one_does_not() {
        let along = Vector3::new(0.6, 0.8, 0.0);
        let capsule = ProbeShape::Capsule { length_m: 0.01, along };
        let ellipsoid = ProbeShape::Ellipsoid { semi_axes_m: [0.01, 0.006], along };
        for shape in [capsule, ellipsoid] {
            let params = Params { probe: Probe { shape, ..Params::default().probe }, ..Params::default() };
            assert_eq!(params.check(), Ok(()));
            let (mut words, length) = packed(params);
            assert_eq!(length, HEADER + size_of::<Tip>());
            assert_eq!(PatchFile::open(&bytemuck::cast_slice(&words)[..length]).unwrap().params, params);
            for short in [length - 4, HEADER] {
                let refused = PatchFile::open(sealed(&mut words, short)).map(|_| ());
                assert_eq!(refused, Err(BuildError::NotAPatch), "{shape:?} cut to {short} bytes");
            }
            // a direction that is NaN, too long, or along the axis; lengths out of range
            let tip = HEADER / 4;
            for (word, value) in [(0, f32::NAN), (0, 1.0), (2, 0.5), (3, f32::NAN), (3, -1e-3), (3, 3.0), (3, f32::INFINITY)] {
                let mut damaged = words;
                damaged[tip + word] = value.to_bits();
                let opened = PatchFile::open(sealed(&mut damaged, length)).map(|file| file.params.check());
                assert!(matches!(opened, Ok(Err(BuildError::OutOfRange { .. }))), "{shape:?} {word} {value}: {opened:?}");
            }
            words[tip + 4] = 1e-3_f32.to_bits();
            let last = PatchFile::open(sealed(&mut words, length)).map(|file| file.params.check());
            match shape {
                ProbeShape::Capsule { .. } => assert!(matches!(last, Err(BuildError::ReservedWord { .. })), "{last:?}"),
                // an eighth of the radius
                _ => assert!(matches!(last, Ok(Err(BuildError::OutOfRange { .. }))), "{last:?}"),
            }
        }
    }
}
