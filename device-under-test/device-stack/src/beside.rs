//! Who stands beside a device: a handle that is nothing for a plain one.

#[cfg(feature = "deviations")]
use alloc::rc::Rc;
#[cfg(feature = "deviations")]
use core::cell::RefCell;
#[cfg(not(feature = "deviations"))]
use core::marker::PhantomData;

/// Who stands beside a device and lets it deviate, if anybody does.
pub struct Beside<D: ?Sized> {
    #[cfg(feature = "deviations")]
    who: Option<Rc<RefCell<D>>>,
    #[cfg(not(feature = "deviations"))]
    nobody: PhantomData<D>,
}

impl<D: ?Sized> Beside<D> {
    /// Nobody.
    #[cfg(feature = "deviations")]
    pub const NOBODY: Beside<D> = Beside { who: None };
    /// Nobody.
    #[cfg(not(feature = "deviations"))]
    pub const NOBODY: Beside<D> = Beside { nobody: PhantomData };

    /// Somebody.
    #[cfg(feature = "deviations")]
    pub fn of(who: Rc<RefCell<D>>) -> Beside<D> {
        Beside { who: Some(who) }
    }

    /// What becomes of `right` by whoever is there; one who looks at the device while being asked sees it plain.
    #[inline]
    pub fn ask<T>(&self, right: T, ask: impl FnOnce(&mut D, T) -> T) -> T {
        #[cfg(feature = "deviations")]
        if let Some(mut who) = self.who.as_ref().and_then(|who| who.try_borrow_mut().ok()) {
            return ask(&mut who, right);
        }
        #[cfg(not(feature = "deviations"))]
        let _ = ask;
        right
    }

    /// Tells whoever is there.
    #[inline]
    pub fn tell(&self, tell: impl FnOnce(&mut D)) {
        self.ask((), |who, ()| tell(who));
    }

    /// Whether anybody is there.
    #[inline]
    pub fn is_anybody(&self) -> bool {
        #[cfg(feature = "deviations")]
        return self.who.is_some();
        #[cfg(not(feature = "deviations"))]
        false
    }
}

impl<D: ?Sized> Clone for Beside<D> {
    fn clone(&self) -> Beside<D> {
        Beside {
            #[cfg(feature = "deviations")]
            who: self.who.clone(),
            #[cfg(not(feature = "deviations"))]
            nobody: PhantomData,
        }
    }
}

impl<D: ?Sized> Default for Beside<D> {
    fn default() -> Beside<D> {
        Beside::NOBODY
    }
}
