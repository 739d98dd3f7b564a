// Palpate from C#: this file alone, for Unity and any .NET, over the C library (palpate_c.dll, libpalpate_c.so or
// libpalpate_c.dylib). Structs and functions have the header's names; `include/palpate.h` states every unit.
// A test compares each of them with the header.
using System;
using System.Runtime.InteropServices;
using System.Text;

namespace Palpate {
    // Result of a call.
    public enum Code {
        Ok = 0, Fault = 1, Null = 2, NotText = 3, WrongSize = 4, OutOfRange = 5, NoSession = 6, Busy = 7, WrongOrder = 8,
        TooMany = 9, CannotRead = 10, BadScene = 11, BadPatch = 12, TooSlow = 13, Internal = 14, NotCommissioned = 15,
    }

    // Operating mode; a force may act in Active, Degraded and, while it falls, in SafeRamp.
    public enum Mode { Boot = 0, SelfTest = 1, Idle = 2, Arming = 3, Active = 4, Degraded = 5, SafeRamp = 6, Fault = 7 }

    // Step of a commissioning.
    public enum Stage { Start = 0, Move = 1, LetGo = 2, Drive = 3, Done = 4, Stopped = 5 }

    // Three numbers in the frame of the scene: x to the operator, y to the operator's right, z up.
    [StructLayout(LayoutKind.Sequential)]
    public struct Vector {
        public double x, y, z;
        public Vector(double x, double y, double z) { this.x = x; this.y = y; this.z = z; }
    }

    // A reading of the device; every field but the position may stay zero.
    [StructLayout(LayoutKind.Sequential)]
    public struct Input {
        public Vector tip_m;
        public uint late_ticks;
        public byte stale, sensor_failed, operator_absent, reserved;
    }

    // Record of the last tick.
    [StructLayout(LayoutKind.Sequential)]
    public struct Report {
        public Vector tip_m, force_n, tissue_n, normal;
        public double depth_m, given_j, youngs_modulus_pa, waiting_modulus_pa;
        public uint ticks;
        public int mode, fault;
        public uint limiters;
        public byte contact, refused;
        public Six reserved;
    }

    // Six bytes that a report reserves.
    [StructLayout(LayoutKind.Sequential, Size = 6)]
    public struct Six { private readonly byte first; }

    // Contact of the tissue with the probe, before damping, gains and limits of the loop.
    [StructLayout(LayoutKind.Sequential)]
    public struct Contact {
        public Vector normal_n, friction_n, torque_nm, centre_m;
        public Axes axes;
        public Pair half_lengths_m;
        public double area_m2, peak_pressure_pa;
        public uint triangles, reserved;
    }

    // Unit vectors along the principal axes of a contact.
    [StructLayout(LayoutKind.Sequential)]
    public struct Axes { public Vector longer, shorter; }

    [StructLayout(LayoutKind.Sequential)]
    public struct Pair { public double longer, shorter; }

    // Tissue, probe and device of a session.
    [StructLayout(LayoutKind.Sequential)]
    public struct Info {
        public Vector site_m, axis, workspace_low_m, workspace_high_m;
        public double probe_radius_m, depth_limit_m, max_force_n, youngs_modulus_pa;
        public ulong nodes, triangles;
    }

    // A call failed; the message says why in one line.
    public sealed class PalpateException : Exception {
        public readonly Code Code;
        public PalpateException(Code code, string message) : base(message) { Code = code; }
    }

    // The loop around your device. Call it from one thread at a time: a second thread gets Code.Busy. Dispose of it when
    // the device has received a force of zero.
    public sealed class Session : IDisposable {
        private ulong handle;

        private Session(ulong handle) { this.handle = handle; }

        // Opens a scene by name or file; `patch` is a patch file in place of the scene's own.
        public static Session Open(string scene, string patch = null, string device = "touch") {
            ulong handle;
            Check(Native.palpate_open_scene(Utf8(scene), Utf8(patch), Utf8(device), out handle));
            return new Session(handle);
        }

        public static Session OpenPatch(string path, string device = "touch") {
            ulong handle;
            Check(Native.palpate_open_patch(Utf8(path), Utf8(device), out handle));
            return new Session(handle);
        }

        public static Session OpenPatch(byte[] content, string device = "touch") {
            ulong handle;
            Check(Native.palpate_open_patch_bytes(content, (UIntPtr)content.Length, Utf8(device), out handle));
            return new Session(handle);
        }

        public void Dispose() {
            // a tick that runs in another thread will end soon
            while (handle != 0 && Native.palpate_close(handle) == Code.Busy) {}
            handle = 0;
            GC.SuppressFinalize(this);
        }

        ~Session() { Dispose(); }

        // One tick of 1 ms: a position [m] in, a force [N] out, which is zero unless Code.Ok is returned. Neither form of
        // it allocates or throws.
        public Code Tick(Vector tip_m, out Vector force_n) { return Native.palpate_tick(handle, ref tip_m, out force_n); }

        public Code Tick(ref Input input, out Vector force_n) {
            return Native.palpate_tick_with(handle, ref input, Size<Input>.Bytes, out force_n);
        }

        // Requests the force: it is there once the tip has been outside and calm for 0.1 s, after a ramp of 0.5 s.
        public void Arm() { Check(Native.palpate_arm(handle)); }

        public void Stop() { Check(Native.palpate_stop(handle)); }

        public void Clear() { Check(Native.palpate_clear(handle)); }

        public void Reset() { Check(Native.palpate_reset(handle)); }

        public void SetModulus(double youngs_modulus_pa) { Check(Native.palpate_set_modulus(handle, youngs_modulus_pa)); }

        // A unit quaternion x, y, z, w.
        public void Turn(double[] orientation) {
            if (orientation.Length != 4) throw new ArgumentException("orientation: give x, y, z and w");
            Check(Native.palpate_turn(handle, orientation));
        }

        public void LowerForce(double max_force_n) { Check(Native.palpate_lower_force(handle, max_force_n)); }

        public Report Report {
            get {
                Report report;
                Check(Native.palpate_read_report(handle, out report, Size<Report>.Bytes));
                return report;
            }
        }

        // Computed when it is read; it changes no tick.
        public Contact Contact {
            get {
                Contact contact;
                Check(Native.palpate_read_contact(handle, out contact, Size<Contact>.Bytes));
                return contact;
            }
        }

        public Info Info {
            get {
                Info info;
                Check(Native.palpate_read_info(handle, out info, Size<Info>.Bytes));
                return info;
            }
        }

        // Copies the nodes' positions [m] for drawing: x, y, z of one node after the other, three times Info.nodes.
        public void ReadNodes(double[] positions_m) {
            Check(Native.palpate_read_nodes(handle, positions_m, (UIntPtr)positions_m.Length));
        }

        // Three nodes for each triangle of the surface, counter-clockwise seen from outside.
        public uint[] Triangles {
            get {
                var corners = new uint[3 * (int)Info.triangles];
                Check(Native.palpate_read_triangles(handle, corners, (UIntPtr)corners.Length));
                return corners;
            }
        }

        public ulong StateHash {
            get {
                ulong hash;
                Check(Native.palpate_state_hash(handle, out hash));
                return hash;
            }
        }

        // What the device's profile leaves open, with the cautious values that are taken.
        public string Cautions {
            get {
                var text = new byte[4096];
                Check(Native.palpate_read_cautions(handle, text, (UIntPtr)text.Length));
                return Text(text);
            }
        }

        // One tick of a commissioning in place of Tick: the sensors' values in, the motors' forces out.
        public Code Commission(Vector reading, double distance_m, bool confirmed, out Vector force_n, out Stage stage) {
            int number;
            var code = Native.palpate_commission(handle, ref reading, distance_m, confirmed ? 1 : 0, out force_n, out number);
            stage = (Stage)number;
            return code;
        }

        public string CommissionText(double distance_m) {
            var text = new byte[1024];
            Check(Native.palpate_commission_text(handle, distance_m, text, (UIntPtr)text.Length));
            return Text(text);
        }

        public void WriteProfile(string path) { Check(Native.palpate_write_profile(handle, Utf8(path))); }

        public static string Version { get { return Text(Native.palpate_version()); } }

        // Why the last call of this thread failed, in one line.
        public static string LastMessage { get { return Text(Native.palpate_last_message()); } }

        public static string ErrorText(Code code) { return Text(Native.palpate_error_text((int)code)); }

        public static string ModeText(int mode) { return Text(Native.palpate_mode_text(mode)); }

        public static string FaultText(int fault) { return Text(Native.palpate_fault_text(fault)); }

        private static void Check(Code code) {
            if (code != Code.Ok) throw new PalpateException(code, LastMessage);
        }

        private static byte[] Utf8(string text) { return text == null ? null : Encoding.UTF8.GetBytes(text + "\0"); }

        private static string Text(byte[] text) { return Encoding.UTF8.GetString(text, 0, Array.IndexOf(text, (byte)0)); }

        private static string Text(IntPtr text) {
            var length = 0;
            while (Marshal.ReadByte(text, length) != 0) length++;
            var bytes = new byte[length];
            Marshal.Copy(text, bytes, 0, length);
            return Encoding.UTF8.GetString(bytes);
        }

        // Computed once: Marshal.SizeOf allocates.
        private static class Size<T> {
            internal static readonly UIntPtr Bytes = (UIntPtr)Marshal.SizeOf(typeof(T));
        }
    }

    internal static class Native {
        private const string Library = "palpate_c";

        [DllImport(Library)]
        internal static extern Code palpate_open_scene(byte[] scene, byte[] patch, byte[] device, out ulong session);
        [DllImport(Library)]
        internal static extern Code palpate_open_patch(byte[] path, byte[] device, out ulong session);
        [DllImport(Library)]
        internal static extern Code palpate_open_patch_bytes(byte[] bytes, UIntPtr length, byte[] device, out ulong session);
        [DllImport(Library)]
        internal static extern Code palpate_close(ulong session);
        [DllImport(Library)]
        internal static extern Code palpate_tick(ulong session, ref Vector tip_m, out Vector force_n);
        [DllImport(Library)]
        internal static extern Code palpate_tick_with(ulong session, ref Input input, UIntPtr input_bytes, out Vector force_n);
        [DllImport(Library)]
        internal static extern Code palpate_commission(
            ulong session, ref Vector reading, double distance_m, int confirmed, out Vector force_n, out int stage);
        [DllImport(Library)]
        internal static extern Code palpate_commission_text(ulong session, double distance_m, [Out] byte[] text, UIntPtr capacity);
        [DllImport(Library)]
        internal static extern Code palpate_read_cautions(ulong session, [Out] byte[] text, UIntPtr capacity);
        [DllImport(Library)]
        internal static extern Code palpate_write_profile(ulong session, byte[] path);
        [DllImport(Library)]
        internal static extern Code palpate_read_report(ulong session, out Report report, UIntPtr report_bytes);
        [DllImport(Library)]
        internal static extern Code palpate_read_contact(ulong session, out Contact contact, UIntPtr contact_bytes);
        [DllImport(Library)]
        internal static extern Code palpate_read_info(ulong session, out Info info, UIntPtr info_bytes);
        [DllImport(Library)]
        internal static extern Code palpate_read_nodes(ulong session, [Out] double[] positions_m, UIntPtr capacity);
        [DllImport(Library)]
        internal static extern Code palpate_read_triangles(ulong session, [Out] uint[] corners, UIntPtr capacity);
        [DllImport(Library)]
        internal static extern Code palpate_state_hash(ulong session, out ulong hash);
        [DllImport(Library)]
        internal static extern Code palpate_arm(ulong session);
        [DllImport(Library)]
        internal static extern Code palpate_stop(ulong session);
        [DllImport(Library)]
        internal static extern Code palpate_clear(ulong session);
        [DllImport(Library)]
        internal static extern Code palpate_reset(ulong session);
        [DllImport(Library)]
        internal static extern Code palpate_set_modulus(ulong session, double youngs_modulus_pa);
        [DllImport(Library)]
        internal static extern Code palpate_turn(ulong session, double[] orientation);
        [DllImport(Library)]
        internal static extern Code palpate_lower_force(ulong session, double max_force_n);
        [DllImport(Library)]
        internal static extern IntPtr palpate_error_text(int code);
        [DllImport(Library)]
        internal static extern IntPtr palpate_mode_text(int mode);
        [DllImport(Library)]
        internal static extern IntPtr palpate_fault_text(int fault);
        [DllImport(Library)]
        internal static extern IntPtr palpate_last_message();
        [DllImport(Library)]
        internal static extern IntPtr palpate_version();
    }
}
