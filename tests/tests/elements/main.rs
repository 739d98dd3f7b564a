//! Meshes and finite elements.

mod block_mesh;
mod contact_map;
mod far_field;
mod fem_reference;
mod field_files;
mod file_variants;
mod fingerprint;
mod fuzz;
mod guide_lists_what_is_read;
mod known_tissues_are_identified;
mod mesh_import;
mod organ_meshes;
mod solved_again;
mod statics_agree;
mod stiffening_agrees;
mod stiffening_regions;
mod surface_files;
mod tests_are_read_as_they_are_recorded;
mod tilted_tips;
mod usd_text;
mod whole_organ;
