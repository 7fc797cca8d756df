//! The handle by which a device calls the hooks of the deviations attached to it. Without the feature `deviations` it
//! is empty.

#[cfg(feature = "deviations")]
use alloc::rc::Rc;
#[cfg(feature = "deviations")]
use core::cell::RefCell;
#[cfg(not(feature = "deviations"))]
use core::marker::PhantomData;

/// The hooks of the deviations of one device, if there are any. `H` is the trait of the hooks.
pub struct Attached<H: ?Sized> {
    #[cfg(feature = "deviations")]
    hooks: Option<Rc<RefCell<H>>>,
    #[cfg(not(feature = "deviations"))]
    hooks: PhantomData<H>,
}

impl<H: ?Sized> Attached<H> {
    /// No deviations.
    #[cfg(feature = "deviations")]
    pub const NONE: Attached<H> = Attached { hooks: None };
    /// No deviations.
    #[cfg(not(feature = "deviations"))]
    pub const NONE: Attached<H> = Attached { hooks: PhantomData };

    /// A handle that calls `hooks`.
    #[cfg(feature = "deviations")]
    pub fn new(hooks: Rc<RefCell<H>>) -> Attached<H> {
        Attached { hooks: Some(hooks) }
    }

    /// Passes `value`, the result that the manual requires, through `hook` and returns the result. A hook that calls
    /// back into the device gets values without deviations.
    #[inline(always)]
    pub fn apply<T>(&self, value: T, hook: impl FnOnce(&mut H, T) -> T) -> T {
        #[cfg(feature = "deviations")]
        if let Some(hooks) = &self.hooks {
            return call(hooks, value, hook);
        }
        #[cfg(not(feature = "deviations"))]
        let _ = hook;
        value
    }

    /// Reports an event to the deviations, or lets them change the values that `hook` captures.
    #[inline]
    pub fn notify(&self, hook: impl FnOnce(&mut H)) {
        self.apply((), |hooks, ()| hook(hooks));
    }

    /// Whether any deviation is attached. Use it to skip preparing costly arguments for hooks.
    #[inline]
    pub fn is_any(&self) -> bool {
        #[cfg(feature = "deviations")]
        return self.hooks.is_some();
        #[cfg(not(feature = "deviations"))]
        false
    }
}

/// Calls the hook. It is not inlined, so a device without deviations pays one comparison per hook.
#[cfg(feature = "deviations")]
#[cold]
#[inline(never)]
fn call<H: ?Sized, T>(hooks: &RefCell<H>, value: T, hook: impl FnOnce(&mut H, T) -> T) -> T {
    match hooks.try_borrow_mut() {
        Ok(mut hooks) => hook(&mut hooks, value),
        Err(_) => value,
    }
}

impl<H: ?Sized> Clone for Attached<H> {
    fn clone(&self) -> Attached<H> {
        Attached {
            #[cfg(feature = "deviations")]
            hooks: self.hooks.clone(),
            #[cfg(not(feature = "deviations"))]
            hooks: PhantomData,
        }
    }
}

impl<H: ?Sized> Default for Attached<H> {
    fn default() -> Attached<H> {
        Attached::NONE
    }
}

impl<H: ?Sized> core::fmt::Debug for Attached<H> {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.debug_struct("Attached").field("is_any", &self.is_any()).finish()
    }
}
